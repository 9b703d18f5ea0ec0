"""Other libraries' functions, with their own signatures, and anti-aliased where pixels cover several texels."""

from . import cv2, skimage, torch

__all__ = ["cv2", "skimage", "torch"]
