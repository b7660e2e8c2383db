"""Restores a network for further training from the shipped file.

The shipped file has each batch normalization merged into its convolution, and perhaps integers in place of weights.
They are converted back, so that the weights of a training need not be stored for the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from torch import Tensor, nn

Net = TypeVar("Net", bound=nn.Module)
Layer = tuple[np.ndarray[Any, Any], np.ndarray[Any, Any] | None]
"""Weights and bias of a layer."""
Modules = Sequence[tuple[nn.Module, nn.BatchNorm2d | None]]
"""Layers of a network in the order of computation, each with the batch normalization after it."""
_KINDS = ("Conv", "ConvTranspose", "Gemm", "MatMul")


class RestoreError(RuntimeError):
    """The file holds no network that can be restored; the message has its name and the reason."""


def layers_of(file: Path) -> list[Layer]:
    """Return the layers of an exported network in the order of computation. `fill` puts them into a network."""
    import onnx

    graph = onnx.load(str(file)).graph
    values = _values(graph)
    return [
        (values[node.input[1]], values.get(node.input[2]) if len(node.input) > 2 else None)
        for node in graph.node
        if node.op_type in _KINDS
    ]


def restored_by(build: Callable[[Sequence[Layer]], tuple[Net, Modules]], file: Path, what: str, give: str) -> Net:
    """Return the network of an exported file.

    Args:
        build: Makes an empty network of the layers' sizes, and names its modules.
        file: The exported file.
        what: The network, for the message.
        give: The files that may be given, for the message.

    Raises:
        RestoreError: The file cannot be read, or holds another network.
    """
    try:
        layers = layers_of(file)
        net, modules = build(layers)
        fill(modules, layers)
    except Exception as error:  # noqa: BLE001 - a file that is not ours fails anywhere
        raise RestoreError(f"no {what} to continue from: {file} ({error}). Give a {give}") from None
    return net


def fill(modules: Modules, layers: Sequence[Layer]) -> None:
    """Copy weights and biases. The batch normalizations only add the merged bias.

    Raises:
        ValueError: The layers are those of another network.
    """
    if len(modules) != len(layers):
        raise ValueError(f"expected {len(modules)} layers, got {len(layers)}")
    with torch.no_grad():
        for (module, normalization), (weight, bias) in zip(modules, layers, strict=True):
            into: Any = module.weight
            # A product of matrices has transposed weights.
            source = weight.T if isinstance(module, nn.Linear) and module.bias is None else weight
            if tuple(source.shape) != tuple(into.shape):
                raise ValueError(f"expected a layer of shape {tuple(into.shape)}, got {source.shape}")
            into.copy_(torch.from_numpy(np.array(source)))
            if bias is not None:
                target: Any = normalization.bias if normalization is not None else module.bias
                target.copy_(torch.from_numpy(np.array(bias)))
            if normalization is not None:
                # Otherwise its small constant under the root would scale the output.
                normalization.weight.fill_((1.0 + normalization.eps) ** 0.5)


def mean_of(first: Mapping[str, Tensor], second: Mapping[str, Tensor], share: float) -> dict[str, Tensor]:
    """Return the weighted mean of two state dicts of one shape; `share` is the weight of the other (0 to 1).

    A network that is trained further on new data forgets some of its abilities. Its weights lie near the old ones, and
    their mean preserves most of both (Wortsman et al. 2022, "Robust fine-tuning of zero-shot models").
    """
    return {
        name: value + share * (second[name] - value) if value.is_floating_point() else value
        for name, value in first.items()
    }


def settle(net: nn.Module, run: Callable[[], object]) -> None:
    """Give the batch normalizations of a restored network the statistics of real input, without changing its output.

    Args:
        net: A network whose batch normalizations have a mean of 0 and a variance of 1.
        run: Feeds the network one batch of typical windows.
    """

    def measure(layer: nn.Module, inputs: tuple[Tensor, ...]) -> None:
        assert isinstance(layer, nn.BatchNorm2d) and layer.running_mean is not None and layer.running_var is not None
        values = inputs[0].float()
        mean, variance = values.mean(dim=(0, 2, 3)), values.var(dim=(0, 2, 3))
        scale = layer.weight / torch.sqrt(layer.running_var + layer.eps)
        layer.bias += scale * (mean - layer.running_mean)
        layer.weight.copy_(scale * torch.sqrt(variance + layer.eps))
        layer.running_mean.copy_(mean)
        layer.running_var.copy_(variance)

    hooks = [
        module.register_forward_pre_hook(measure) for module in net.modules() if isinstance(module, nn.BatchNorm2d)
    ]
    was_training = net.training
    with torch.no_grad():
        net.eval()
        run()
    net.train(was_training)
    for hook in hooks:
        hook.remove()


def _values(graph: Any) -> dict[str, np.ndarray[Any, Any]]:
    """Return the constants of a graph by name, and those that it converts from integers to floating-point numbers."""
    from onnx import numpy_helper

    values = {item.name: numpy_helper.to_array(item) for item in graph.initializer}
    for node in graph.node:
        if node.op_type != "DequantizeLinear" or node.input[0] not in values:
            continue
        whole, scale, zero = (values[name] for name in node.input)
        axis = next((item.i for item in node.attribute if item.name == "axis"), 1)
        shape = [-1 if i == axis else 1 for i in range(whole.ndim)] if scale.ndim else []
        values[node.output[0]] = (whole.astype(np.float32) - zero.reshape(shape)) * scale.reshape(shape)
    return values
