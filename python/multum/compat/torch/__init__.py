"""PyTorch's image sampling, ``torch.nn.functional``'s names and rules, without PyTorch.

NumPy arrays in, NumPy arrays out. Tensors of PyTorch, JAX and whatever else speaks DLPack are read in place, on the
CPU, and the result is a tensor of the same library. Layout is (N, C, H, W) in any strides; contiguous tensors and
those with channels last in memory are not copied, others once.

Gradients are explicit: :func:`grid_sample_backward`. Where PyTorch can be imported, ``GridSample`` is a
``torch.autograd.Function`` of the two: ``GridSample.apply(input, grid, mode, padding_mode, align_corners)``.

    >>> import numpy as np
    >>> from multum.compat.torch import affine_grid, grid_sample
    >>> image = np.arange(12.0).reshape(1, 1, 3, 4)
    >>> mirrored = affine_grid(np.array([[[-1.0, 0, 0], [0, 1, 0]]]), (1, 1, 3, 4), align_corners=False)
    >>> grid_sample(image, mirrored, align_corners=False)[0, 0, 0].tolist()
    [3.0, 2.0, 1.0, 0.0]
"""

from typing import Any

from ._backward import grid_sample_backward
from ._grid import affine_grid, grid_sample
from ._interpolate import interpolate
from ._tensors import error

__all__ = ["affine_grid", "error", "grid_sample", "grid_sample_backward", "interpolate"]


def __getattr__(name: str) -> Any:
    """``GridSample``, made when it is first asked for: it needs PyTorch."""
    if name != "GridSample":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from ._autograd import grid_sample_function

    return grid_sample_function()
