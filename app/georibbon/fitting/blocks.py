"""Symmetric positive definite systems of dense blocks, few of them filled.

The passes of a survey touch only their neighbours, their ties and what all
share, so the normal equations are a graph of blocks.  Blockwise Cholesky
factorisation in a minimum-degree order keeps the work in proportion to the
number of passes; the inverse is computed only where the factor is filled
(Takahashi, Fagan and Chin 1973), which holds every covariance that is asked for.
"""

from dataclasses import dataclass

import numpy as np

from georibbon.arrays import FloatArray

Key = tuple[int, int]


class BlockMatrix:
    """A symmetric matrix of blocks; only blocks (i, j) with i >= j are held."""

    def __init__(self, sizes: list[int]) -> None:
        """An empty matrix with the given sizes of its diagonal blocks."""
        self.sizes = sizes
        self.blocks: dict[Key, FloatArray] = {
            (i, i): np.zeros((size, size)) for i, size in enumerate(sizes)
        }

    def add(self, i: int, j: int, block: FloatArray) -> None:
        """Adds (size i, size j) to block (i, j), and so its transpose to (j, i)."""
        if i < j:
            i, j, block = j, i, block.T
        if (i, j) in self.blocks:
            self.blocks[i, j] += block
        else:
            self.blocks[i, j] = block.copy()

    def damped(self, factor: float) -> "BlockMatrix":
        """The matrix with its diagonal enlarged by the factor; its other blocks are shared."""
        out = BlockMatrix(self.sizes)
        out.blocks = dict(self.blocks)
        for i in range(len(self.sizes)):
            block = self.blocks[i, i]
            out.blocks[i, i] = block + factor * np.diag(np.diagonal(block))
        return out


@dataclass(frozen=True, eq=False)
class BlockFactor:
    """The Cholesky factor: inverses of diagonal blocks' factors and columns below them.

    order: the blocks as eliminated.  inverse: for each block L_jj^-1.
    below: for each block {i: L_ij}, i eliminated later.
    """

    sizes: list[int]
    order: list[int]
    inverse: dict[int, FloatArray]
    below: dict[int, dict[int, FloatArray]]

    def solve(self, right: list[FloatArray]) -> list[FloatArray]:
        """x with A x = right, block by block."""
        x = [part.copy() for part in right]
        for j in self.order:
            x[j] = self.inverse[j] @ x[j]
            for i, block in self.below[j].items():
                x[i] -= block @ x[j]
        for j in reversed(self.order):
            for i, block in self.below[j].items():
                x[j] -= block.T @ x[i]
            x[j] = self.inverse[j].T @ x[j]
        return x

    def covariance(self) -> dict[Key, FloatArray]:
        """The blocks of the inverse wherever the factor is filled, keyed both ways round."""
        z: dict[Key, FloatArray] = {}
        for j in reversed(self.order):
            rows = list(self.below[j])
            own = self.inverse[j].T @ self.inverse[j]
            if rows:
                y = np.concatenate([self.below[j][i] for i in rows]) @ self.inverse[j]
                among = np.block([[z[i, k] for k in rows] for i in rows])
                column = -among @ y
                own = own - y.T @ column
                ends = np.cumsum([self.sizes[i] for i in rows])[:-1]
                for i, part in zip(rows, np.split(column, ends), strict=True):
                    z[i, j], z[j, i] = part, part.T
            z[j, j] = 0.5 * (own + own.T)
        return z


def factorise(matrix: BlockMatrix) -> BlockFactor:
    """Blockwise Cholesky; raises numpy.linalg.LinAlgError where the matrix is not definite."""
    work: dict[int, dict[int, FloatArray]] = {i: {} for i in range(len(matrix.sizes))}
    for (i, j), block in matrix.blocks.items():
        work[i][j] = block
        work[j][i] = block.T
    order, inverse, below = [], {}, {}
    remaining = set(work)
    while remaining:
        j = min(remaining, key=lambda i: (len(work[i]), matrix.sizes[i], i))
        remaining.remove(j)
        inverse[j] = np.linalg.inv(np.linalg.cholesky(work[j].pop(j)))
        below[j] = {i: block.T @ inverse[j].T for i, block in work[j].items()}
        order.append(j)
        _eliminate(work, j, below[j])
    return BlockFactor(matrix.sizes, order, inverse, below)


def _eliminate(
    work: dict[int, dict[int, FloatArray]], j: int, column: dict[int, FloatArray]
) -> None:
    """Subtracts L_ij L_kj^T from every pair of blocks that j touches."""
    for i in column:
        del work[i][j]
    places = list(column)
    for a, i in enumerate(places):
        for k in places[: a + 1]:
            update = column[i] @ column[k].T
            held = work[i].get(k)
            work[i][k] = -update if held is None else held - update
            if i != k:
                work[k][i] = work[i][k].T
