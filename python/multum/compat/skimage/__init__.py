"""scikit-image's warps, resizing and pyramids: the same names, signatures, defaults, dtypes, warnings and errors,
without scikit-image.

Change ``from skimage.transform import warp`` to ``from multum.compat.skimage import warp``. Results are those of
scikit-image 0.26: for matrices and linear interpolation to the last bit, elsewhere to rounding. The functions that
interpolate in two dimensions at orders 0, 1 and (by a matrix) 3 need NumPy alone. Orders 2 to 5 elsewhere, and
coordinate arrays of volumes, need SciPy, and say so where it is absent.

Beyond scikit-image: :func:`warp`, :func:`rotate`, :func:`swirl` and :func:`warp_polar` take ``antialias``. With
``True``, pixels that cover more than a pixel of the input are averaged over what they cover.

    >>> import numpy as np
    >>> from multum.compat.skimage import rescale, warp
    >>> board = np.indices((64, 64)).sum(0) % 2.0
    >>> third = np.diag([3.0, 3.0, 1.0])
    >>> plain = warp(board, third, output_shape=(20, 20))
    >>> [float(v) for v in (plain.min(), plain.max())]      # noise: every third pixel
    [0.0, 1.0]
    >>> smooth = warp(board, third, output_shape=(20, 20), mode="edge", antialias=True)
    >>> bool(abs(smooth[1:, 1:] - 0.5).max() < 0.06)
    True
    >>> rescale(board, 0.5).shape
    (32, 32)
"""

from ._integral import integral_image, integrate
from ._matrices import (
    AffineTransform,
    EuclideanTransform,
    ProjectiveTransform,
    SimilarityTransform,
    matrix_transform,
)
from ._means import downscale_local_mean, resize_local_mean
from ._pyramids import pyramid_expand, pyramid_gaussian, pyramid_laplacian, pyramid_reduce
from ._resize import rescale, resize
from ._turns import rotate, swirl, warp_polar
from ._warp import warp, warp_coords

__all__ = [
    "AffineTransform",
    "EuclideanTransform",
    "ProjectiveTransform",
    "SimilarityTransform",
    "downscale_local_mean",
    "integral_image",
    "integrate",
    "matrix_transform",
    "pyramid_expand",
    "pyramid_gaussian",
    "pyramid_laplacian",
    "pyramid_reduce",
    "rescale",
    "resize",
    "resize_local_mean",
    "rotate",
    "swirl",
    "warp",
    "warp_coords",
    "warp_polar",
]
