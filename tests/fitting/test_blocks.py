"""Block systems: the same as dense algebra, at the cost of the blocks that are filled."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from georibbon.fitting.blocks import BlockMatrix, factorise


def random_system(seed, blocks, share):
    """A sparse positive definite BlockMatrix and the same as a dense matrix."""
    rng = np.random.default_rng(seed)
    sizes = [int(size) for size in rng.integers(1, 5, blocks)]
    ends = np.concatenate([[0], np.cumsum(sizes)])
    matrix, dense = BlockMatrix(sizes), np.zeros((ends[-1], ends[-1]))
    for i in range(blocks):
        for j in range(blocks):
            if i != j and rng.random() > share:
                continue
            # One equation system that touches i and j, in either order.
            a, b = rng.normal(size=(6, sizes[i])), rng.normal(size=(6, sizes[j]))
            row = np.zeros((6, ends[-1]))
            row[:, ends[i] : ends[i + 1]] += a
            if i != j:
                row[:, ends[j] : ends[j + 1]] += b
                matrix.add(i, j, a.T @ b)
                matrix.add(j, j, b.T @ b)
            matrix.add(i, i, a.T @ a)
            dense += row.T @ row
    return matrix, dense, ends


def split(vector, ends):
    return [vector[a:b] for a, b in pairwise(ends)]


systems = st.tuples(st.integers(0, 10**6), st.integers(1, 9), st.floats(0.0, 0.6))


@given(systems)
def test_solving_is_dense_solving(of):
    matrix, dense, ends = random_system(*of)
    right = np.random.default_rng(of[0]).normal(size=len(dense))
    found = np.concatenate(factorise(matrix).solve(split(right, ends)))
    scale = np.abs(np.linalg.inv(dense)).max()
    np.testing.assert_allclose(found, np.linalg.solve(dense, right), atol=1e-9 * (1 + scale**2))


@given(systems)
def test_the_covariance_is_the_inverse_wherever_something_was_held(of):
    matrix, dense, ends = random_system(*of)
    inverse = np.linalg.inv(dense)
    covariance = factorise(matrix).covariance()
    for i, j in matrix.blocks:
        expected = inverse[ends[i] : ends[i + 1], ends[j] : ends[j + 1]]
        tolerance = 1e-9 * (1 + np.abs(inverse).max() ** 2)
        np.testing.assert_allclose(covariance[i, j], expected, atol=tolerance)
        np.testing.assert_array_equal(covariance[j, i], covariance[i, j].T)


@given(systems)
def test_solving_leaves_matrix_and_right_side_as_they_were(of):
    matrix, dense, ends = random_system(*of)
    before = {key: block.copy() for key, block in matrix.blocks.items()}
    right = split(np.ones(len(dense)), ends)
    factorise(matrix.damped(0.5)).solve(right)
    factorise(matrix).covariance()
    assert all((part == 1).all() for part in right)
    for key, block in matrix.blocks.items():
        np.testing.assert_array_equal(block, before[key])


def test_a_block_may_be_added_from_either_side():
    one, other = BlockMatrix([2, 3]), BlockMatrix([2, 3])
    block = np.arange(6.0).reshape(2, 3)
    for _ in range(2):
        one.add(0, 1, block)
        other.add(1, 0, block.T)
    np.testing.assert_array_equal(one.blocks[1, 0], 2 * block.T)
    np.testing.assert_array_equal(other.blocks[1, 0], 2 * block.T)
    assert (0, 1) not in one.blocks


def test_what_was_added_may_change_afterwards():
    matrix, block = BlockMatrix([1, 1]), np.ones((1, 1))
    matrix.add(1, 0, block)
    block[:] = 7.0
    assert matrix.blocks[1, 0] == 1.0


def test_damping_enlarges_the_diagonal_alone():
    matrix, dense, ends = random_system(3, 5, 0.5)
    damped = matrix.damped(0.25)
    for (i, j), block in damped.blocks.items():
        expected = dense[ends[i] : ends[i + 1], ends[j] : ends[j + 1]].copy()
        if i == j:
            expected += 0.25 * np.diag(np.diag(expected))
        np.testing.assert_allclose(block, expected, rtol=1e-12)


@pytest.mark.parametrize("value", [-1.0, 0.0])
def test_a_matrix_that_is_not_definite_is_refused(value):
    matrix = BlockMatrix([2, 2])
    matrix.add(0, 0, np.eye(2))
    matrix.add(1, 1, np.diag([1.0, value]))
    with pytest.raises(np.linalg.LinAlgError):
        factorise(matrix)


def test_definite_blocks_do_not_make_a_definite_matrix():
    matrix = BlockMatrix([1, 1])
    matrix.add(0, 0, np.eye(1))
    matrix.add(1, 1, np.eye(1))
    matrix.add(0, 1, np.array([[1.5]]))
    with pytest.raises(np.linalg.LinAlgError):
        factorise(matrix)


def chain(count, shared):
    """Blocks each touching the next, and, where asked, all one block that they share."""
    matrix = BlockMatrix([2] * count + [3] * shared)
    for i in range(count):
        matrix.add(i, i, 4 * np.eye(2))
        if i:
            matrix.add(i, i - 1, 0.5 * np.ones((2, 2)))
        if shared:
            matrix.add(count, i, 0.1 * np.ones((3, 2)))
    if shared:
        matrix.add(count, count, 20.0 * np.eye(3))
    return matrix


@pytest.mark.parametrize("count", [10, 50, 200])
@pytest.mark.parametrize("shared", [0, 1])
def test_a_chain_fills_in_proportion_to_its_length(count, shared):
    """Neighbouring passes, and what all share: no block between far passes is ever made."""
    factor = factorise(chain(count, shared))
    filled = sum(len(column) for column in factor.below.values())
    assert filled == (count - 1) + shared * count
    assert len(factor.covariance()) == count + shared + 2 * filled


def test_ties_fill_only_themselves():
    """Ties that cross all passes are eliminated last; passes do not meet through them."""
    passes, ties = 30, 3
    matrix = BlockMatrix([4] * (passes + ties))
    for i in range(passes + ties):
        matrix.add(i, i, 50.0 * np.eye(4))
    for i in range(passes):
        for tie in range(passes, passes + ties):
            matrix.add(i, tie, np.ones((4, 4)))
    factor = factorise(matrix)
    assert sorted(factor.order[-ties:]) == list(range(passes, passes + ties))
    assert sum(len(column) for column in factor.below.values()) == passes * ties + 3
