"""Fields of vectors with their components first, so that every step runs over memory in a row.

Elsewhere vectors are (..., 3); here they are (3, ...).  `outer` and `inner` give
views, so that an array made component by component is handed on without a copy.
"""

import numpy as np

from georibbon.arrays import FloatArray


def inner(vectors: FloatArray) -> FloatArray:
    """(3, ...) in a row in memory, of vectors (..., 3); a view where they were made so."""
    last = vectors.ndim - 1
    return np.ascontiguousarray(vectors.transpose(last, *range(last)))


def outer(components: FloatArray) -> FloatArray:
    """(..., 3) vectors: a view of components (3, ...)."""
    return components.transpose(*range(1, components.ndim), 0)


def dotted(first: FloatArray, second: FloatArray) -> FloatArray:
    """(...) the dot products of fields (3, ...)."""
    product: FloatArray = np.einsum("i...,i...->...", first, second)
    return product


def crossed(first: FloatArray, second: FloatArray) -> FloatArray:
    """(3, ...) the cross products of fields (3, ...)."""
    product = np.empty(np.broadcast_shapes(first.shape, second.shape))
    spare = np.empty(product.shape[1:])
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(first[j], second[k], out=product[i])
        np.multiply(first[k], second[j], out=spare)
        product[i] -= spare
    return product


def interleaved(vectors: FloatArray) -> FloatArray:
    """(..., 3) vectors in a row in memory, one after the other."""
    if vectors.flags.c_contiguous:
        return vectors
    copy = np.empty(vectors.shape)
    for i in range(3):
        copy[..., i] = vectors[..., i]
    return copy
