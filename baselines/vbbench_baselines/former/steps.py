"""The steps that a network is made of when it runs: one kernel takes them from a table, all numbers in one memory.

A step is a row of integers: what is done, how often along three axes, and of the result and each operand where in the
memory it begins and how far apart its numbers are along these axes. What is true is 1, what is not is 0.
"""

import numpy as np
from numpy.typing import NDArray

from vbbench.kernels import kernel

AXES, OPERANDS = 3, 4
STEP_WIDTH = (AXES + 1) * (OPERANDS + 2)
"""Integers of a step."""

COPY, ADD, SUBTRACT, MULTIPLY, DIVIDE, ADD_PRODUCTS, SUBTRACT_PRODUCTS, CHOOSE = range(8)
"""Of a, b, c, d: a; a + b; a − b; ab; a/b; ab + cd; ab − cd; b where a is true, else c."""
LARGER, SMALLER, IS_MORE, IS_LESS, POWER, ANGLE = range(8, 14)
"""The larger and the smaller one, NaN if any is; a > b; a < b; a to the power b; the angle of the point (b, a)."""
EXP, LOG, SQRT, TANH, ASINH, SIGMOID, SILU, COSINE, SINE = range(14, 23)
SUM, LARGEST, MATRIX_PRODUCT = range(23, 26)
"""Of a along the last axis; c [J] + ab of matrices a [I, K] and b [K, J], whose rows have no gaps: axes are I, K, J."""


Steps = NDArray[np.int32]


@kernel
def take_steps(steps: Steps, memory: NDArray[np.float32]) -> None:
    """Take ``steps`` [S, `STEP_WIDTH`] in ``memory`` one after the other."""
    for s in range(len(steps)):
        do, n = steps[s, 0], steps[s, 3]
        if do == MATRIX_PRODUCT:
            _multiply_matrices(steps, s, memory)
            continue
        gap, gap_a, gap_b, gap_c, gap_d = steps[s, 7], steps[s, 11], steps[s, 15], steps[s, 19], steps[s, 23]
        for i in range(steps[s, 1]):
            for j in range(steps[s, 2]):
                to, a, b = _place(steps, s, 4, i, j), _place(steps, s, 8, i, j), _place(steps, s, 12, i, j)
                if do < EXP:
                    c, d = _place(steps, s, 16, i, j), _place(steps, s, 20, i, j)
                    for k in range(n):
                        w, x = memory[a + k * gap_a], memory[b + k * gap_b]
                        y, z = memory[c + k * gap_c], memory[d + k * gap_d]
                        memory[to + k * gap] = _calculated(do, w, x, y, z)
                elif do < SUM:
                    for k in range(n):
                        memory[to + k * gap] = _function(do, memory[a + k * gap_a])
                else:
                    memory[to] = _summary(do, n, memory, a, gap_a)


@kernel
def _place(steps: Steps, s: int, operand: int, i: int, j: int) -> int:
    """Where the numbers of an operand along the last axis begin."""
    place: int = steps[s, operand] + i * steps[s, operand + 1] + j * steps[s, operand + 2]
    return place


@kernel
def _multiply_matrices(steps: Steps, s: int, memory: NDArray[np.float32]) -> None:
    rows, n, columns, gap, below = steps[s, 1], steps[s, 2], steps[s, 3], steps[s, 10], steps[s, 14]
    for i in range(rows):
        to, a = steps[s, 4] + i * steps[s, 5], steps[s, 8] + i * steps[s, 9]
        row = memory[to : to + columns]
        for j in range(columns):
            row[j] = memory[steps[s, 16] + j * steps[s, 19]]
        for k in range(n):
            weight, b = memory[a + k * gap], steps[s, 12] + k * below
            other = memory[b : b + columns]
            for j in range(columns):
                row[j] += weight * other[j]


@kernel
def _calculated(do: int, a: np.float32, b: np.float32, c: np.float32, d: np.float32) -> np.float32:
    """One of `COPY` to `ANGLE`."""
    if do == COPY:
        return a
    if do == ADD:
        return a + b
    if do == SUBTRACT:
        return a - b
    if do == MULTIPLY:
        return a * b
    if do == DIVIDE:
        return a / b
    if do == ADD_PRODUCTS:
        return a * b + c * d
    if do == SUBTRACT_PRODUCTS:
        return a * b - c * d
    if do == CHOOSE:
        return b if a != 0.0 else c
    return _compared(do, a, b)


@kernel
def _compared(do: int, a: np.float32, b: np.float32) -> np.float32:
    """One of `LARGER` to `ANGLE`."""
    if do == LARGER:
        return b if a < b or b != b else a
    if do == SMALLER:
        return b if a > b or b != b else a
    if do == IS_MORE:
        return np.float32(a > b)
    if do == IS_LESS:
        return np.float32(a < b)
    if do == POWER:
        return a**b
    angle: np.float32 = np.arctan2(a, b)
    return angle


@kernel
def _function(do: int, x: np.float32) -> np.float32:
    """One of `EXP` to `SINE` of a number."""
    one = np.float32(1.0)
    made: np.float32
    if do == EXP:
        made = np.exp(x)
    elif do == LOG:
        made = np.log(x)
    elif do == SQRT:
        made = np.sqrt(x)
    elif do == TANH:
        made = np.tanh(x)
    elif do == ASINH:
        made = np.arcsinh(x)
    elif do == SIGMOID:
        made = one / (one + np.exp(-x))
    elif do == SILU:
        made = x / (one + np.exp(-x))
    elif do == COSINE:
        made = np.cos(x)
    else:
        made = np.sin(x)
    return made


@kernel
def _summary(do: int, n: int, memory: NDArray[np.float32], a: int, gap_a: int) -> np.float32:
    """`SUM` or `LARGEST` of ``n`` numbers."""
    if do == SUM:
        made = np.float32(0.0)
        for k in range(n):
            made += memory[a + k * gap_a]
    else:
        made = memory[a]
        for k in range(n):
            x = memory[a + k * gap_a]
            made = x if x > made or x != x else made
    return made
