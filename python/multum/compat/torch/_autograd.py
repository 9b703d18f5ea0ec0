"""The autograd function, where there is PyTorch."""

from functools import cache
from typing import Any

from ._backward import grid_sample_backward
from ._grid import grid_sample


@cache
def grid_sample_function() -> Any:
    """A subclass of ``torch.autograd.Function`` whose ``apply`` takes what :func:`grid_sample` takes."""
    try:
        import torch
    except ImportError as missing:
        raise ImportError("GridSample needs PyTorch: pip install torch") from missing

    class GridSample(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
        """Samples images at a grid, with gradients by both; see :func:`multum.compat.torch.grid_sample`."""

        @staticmethod
        def forward(
            ctx: Any,
            input: Any,
            grid: Any,
            mode: str = "bilinear",
            padding_mode: str = "zeros",
            align_corners: bool = False,
        ) -> Any:
            """Keep what the gradients need, and sample."""
            ctx.save_for_backward(input, grid)
            ctx.how = (mode, padding_mode, align_corners)
            return grid_sample(input, grid, *ctx.how)

        @staticmethod
        def backward(ctx: Any, *grad_outputs: Any) -> Any:
            """Gradients by input and grid; the names have none."""
            input, grid = ctx.saved_tensors
            to_input, to_grid = grid_sample_backward(grad_outputs[0], input, grid, *ctx.how)
            return to_input, to_grid, None, None, None

    return GridSample
