"""A frozen policy as ONNX graphs, for programs in other languages: values and choices of both levels.

What comes out is what the kernels of `task_network.py` and `route_network.py` give, but for the order in which numbers
are added (docs/formats/policy.md, "ONNX").
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.files import replacing
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import FrozenLower

if TYPE_CHECKING:
    import onnx

SUFFIX = ".onnx"
LOWER_SUFFIX = ".lower.onnx"
OPSET, IR_VERSION = 17, 8  # of 2022: what reads them is everywhere
LOWEST = float(np.finfo(np.float32).min)  # Q of what is not valid

UPPER_GRAPH = """
task_level (float[B, N, Do] obs, float[B, N, K, Dt] tasks, int8[B, N, K] action_mask)
    => (float[B, N, K] q, int64[B, N] task) {
    own = MatMul(obs, piece_weight)   own_b = Add(own, piece_bias)   x = Relu(own_b)
    x_e = MatMul(x, embed_piece_weight)   two = Constant <value_ints = [2]> ()   x_k = Unsqueeze(x_e, two)
    t_e = MatMul(tasks, embed_task_weight)   t_b = Add(t_e, embed_task_bias)   t_x = Add(t_b, x_k)   first = Relu(t_x)
    f_e = MatMul(first, embed_weight)   f_b = Add(f_e, embed_bias)   h = Relu(f_b)
    valid = Cast <to = 9> (action_mask)   ones = Cast <to = 1> (valid)
    last = Constant <value_ints = [-1]> ()   weight = Unsqueeze(ones, last)   h_valid = Mul(h, weight)
    total = ReduceSum <keepdims = 0> (h_valid, two)   n = ReduceSum <keepdims = 0> (weight, two)
    one = Constant <value_float = 1.0> ()   n_least = Max(n, one)   z = Div(total, n_least)
    c_x = MatMul(x, context_piece_weight)   c_z = MatMul(z, context_set_weight)
    c = Add(c_x, c_z)   c_b = Add(c, context_set_bias)   c_k = Unsqueeze(c_b, two)
    h_c = MatMul(h, context_task_weight)   both = Add(h_c, c_k)   value = Relu(both)
    v = MatMul(value, value_weight)   v_b = Add(v, value_bias)   q_all = Squeeze(v_b, last)
    lowest = Constant <value_float = LOWEST> ()   q = Where(valid, q_all, lowest)
    task = ArgMax <axis = -1, keepdims = 0> (q)
}
"""

LOWER_GRAPH = """
lower_level (float[n, Dl] state, int8[n, A] mask) => (float[n, A] q, int64[n] answer) {
    a = MatMul(state, layer1_weight)   a_b = Add(a, layer1_bias)   first = Relu(a_b)
    b = MatMul(first, layer2_weight)   b_b = Add(b, layer2_bias)   second = Relu(b_b)
    c = MatMul(second, layer3_weight)   q = Add(c, layer3_bias)
    valid = Cast <to = 9> (mask)   lowest = Constant <value_float = LOWEST> ()   q_valid = Where(valid, q, lowest)
    best = ReduceMax <axes = [-1], keepdims = 1> (q_valid)   least = Sub(best, tie)
    is_best = GreaterOrEqual(q_valid, least)   taken = And(is_best, valid)   rank = Cast <to = 6> (taken)
    answer = ArgMax <axis = -1, keepdims = 0> (rank)
}
"""


def task_graph(policy: FrozenPolicy) -> onnx.ModelProto:
    """The task level: obs [B, N, Do], tasks [B, N, K, Dt], action_mask [B, N, K] -> q [B, N, K], task [B, N].

    Raises:
        ConfigError: the package onnx is missing.
    """
    about = {**policy.about, "n_pieces": str(policy.n_pieces), "n_tasks": str(policy.n_tasks)}
    return _model(UPPER_GRAPH, policy.weights, about)


def route_graph(lower: FrozenLower) -> onnx.ModelProto:
    """The lower level: state [n, Dl], mask [n, 7] -> q [n, 7], answer [n]; `FrozenLower` says what they mean."""
    return _model(LOWER_GRAPH, {**lower.weights, "tie": np.array(lower.tie, np.float32)}, lower.about)


def save_onnx(policy: FrozenPolicy, path: str | Path) -> list[Path]:
    """Write `NAME.onnx`, and `NAME.lower.onnx` if the policy has a lower level that is a network.

    Returns:
        What was written.

    Raises:
        ConfigError: the package onnx is missing.
    """
    models = {Path(path): task_graph(policy)}
    if isinstance(policy.lower, FrozenLower):
        models[Path(path).with_suffix(LOWER_SUFFIX)] = route_graph(policy.lower)
    for file, model in models.items():
        with replacing(file) as temporary:
            temporary.write_bytes(model.SerializeToString())
    return list(models)


def _model(graph: str, weights: Mapping[str, Any], about: Mapping[str, str]) -> onnx.ModelProto:
    """A graph with its weights as they are named in it: matrices [input, output]."""
    try:
        import onnx
    except ModuleNotFoundError as error:
        raise ConfigError('a policy as ONNX needs onnx: pip install "hexwar-sb3[onnx]"') from error
    head = f'<ir_version: {IR_VERSION}, opset_import: ["" : {OPSET}]>'
    model = onnx.parser.parse_model(head + graph.replace("LOWEST", repr(LOWEST)))
    for name, array in weights.items():
        turned = np.ascontiguousarray(array.T, np.float32)
        model.graph.initializer.append(onnx.numpy_helper.from_array(turned, name.replace(".", "_")))
    onnx.helper.set_model_props(model, dict(about))
    onnx.checker.check_model(model, full_check=True)
    return model
