"""The steps that a network is made of when it runs: one kernel takes them from a table, all numbers in one memory.

A step is a row of integers: what is done, how often along three axes, and of the result and each of four operands where
in the memory it begins and how far apart its numbers are along these axes; zeros for operands that it has not. What is
true is 1, what is not is 0.
"""

from math import factorial

import numpy as np
from numpy.typing import NDArray

from vbbench.kernels import kernel

AXES, OPERANDS = 3, 4
STEP_WIDTH = (AXES + 1) * (OPERANDS + 2)
"""Integers of a step."""

ADD, SUBTRACT, MULTIPLY, DIVIDE, COPY, ADD_PRODUCTS, SUBTRACT_PRODUCTS, CHOOSE = range(8)
"""Of a, b, c, d: a + b; a − b; ab; a/b; a; ab + cd; ab − cd; b where a is true, else c."""
LARGER, SMALLER, IS_MORE, IS_LESS, POWER, ANGLE = range(8, 14)
"""The larger and the smaller one, NaN if any is; a > b; a < b; a to the power b; the angle of the point (b, a)."""
EXP, LOG, SQRT, TANH, ASINH, SIGMOID, SILU, COSINE, SINE = range(14, 23)
SUM, SHARES, NORMAL = range(23, 26)
"""Along the last axis: the sum of a; exp(a) over its sum; b times a less its mean, over its spread, plus c.

Rows of a, b, c and of the result have no gaps, but those of which `SUM` is.
"""
MATRIX_PRODUCT = 26
"""c [J] + ab of matrices a [I, K] and b [K, J]; the axes are I, K and J. Rows of b and of the result have no gaps."""

LEAST_VARIANCE = np.float32(1e-5)
LONG = 16
"""From so many numbers on it is worth while to see whether they have no gaps."""

LOWEST, HIGHEST = np.float32(-87.3), np.float32(88.3)
"""Exponents of about the least and greatest numbers."""
LN_2, REST_OF_LN_2 = np.float32(0.693359375), np.float32(np.log(2.0) - 0.693359375)
"""Of the first one any multiple is exact."""
PER_LN_2, HALF, ONE = np.float32(1.0 / np.log(2.0)), np.float32(0.5), np.float32(1.0)
T2, T3, T4, T5, T6, T7 = (np.float32(1.0 / factorial(n)) for n in range(2, 8))

Steps = NDArray[np.int32]
Numbers = NDArray[np.float32]


@kernel
def take_steps(steps: Steps, memory: Numbers) -> None:
    """Take ``steps`` [S, `STEP_WIDTH`] in ``memory`` one after the other."""
    for s in range(len(steps)):
        if steps[s, 0] == MATRIX_PRODUCT:
            _multiply_matrices(steps, s, memory)
            continue
        for i in range(steps[s, 1]):
            for j in range(steps[s, 2]):
                if steps[s, 0] < EXP:
                    _calculate(steps, s, memory, i, j)
                else:
                    _take_row(steps, s, memory, i, j)


@kernel
def _calculate(steps: Steps, s: int, memory: Numbers, i: int, j: int) -> None:
    """`ADD` to `ANGLE` along the last axis."""
    do, n, gap, gap_a, gap_b = steps[s, 0], steps[s, 3], steps[s, 7], steps[s, 11], steps[s, 15]
    to, a, b = _place(steps, s, 4, i, j), _place(steps, s, 8, i, j), _place(steps, s, 12, i, j)
    if do <= DIVIDE and n >= LONG and gap == gap_a == gap_b == 1:
        _combine(do, memory[to : to + n], memory[a : a + n], memory[b : b + n])
        return
    c, d, gap_c, gap_d = _place(steps, s, 16, i, j), _place(steps, s, 20, i, j), steps[s, 19], steps[s, 23]
    for k in range(n):
        w, x = memory[a + k * gap_a], memory[b + k * gap_b]
        y, z = memory[c + k * gap_c], memory[d + k * gap_d]
        memory[to + k * gap] = _calculated(do, w, x, y, z)


@kernel
def _take_row(steps: Steps, s: int, memory: Numbers, i: int, j: int) -> None:
    """`EXP` to `NORMAL` along the last axis."""
    do, n, gap, gap_a = steps[s, 0], steps[s, 3], steps[s, 7], steps[s, 11]
    to, a = _place(steps, s, 4, i, j), _place(steps, s, 8, i, j)
    if do == SUM:
        memory[to] = _sum(memory, n, a, gap_a)
    elif do == SHARES:
        _share(memory[to : to + n], memory[a : a + n])
    elif do == NORMAL:
        b, c = _place(steps, s, 12, i, j), _place(steps, s, 16, i, j)
        _normalise(memory[to : to + n], memory[a : a + n], memory[b : b + n], memory[c : c + n])
    elif do == SILU and gap == gap_a == 1:
        _gate(memory[to : to + n], memory[a : a + n])
    else:
        for k in range(n):
            memory[to + k * gap] = _function(do, memory[a + k * gap_a])


@kernel
def _place(steps: Steps, s: int, operand: int, i: int, j: int) -> int:
    """Where the numbers of an operand along the last axis begin."""
    place: int = steps[s, operand] + i * steps[s, operand + 1] + j * steps[s, operand + 2]
    return place


@kernel
def _multiply_matrices(steps: Steps, s: int, memory: Numbers) -> None:
    """A `MATRIX_PRODUCT`; four rows of b are added at a time, in their order."""
    rows, n, columns, gap, below = steps[s, 1], steps[s, 2], steps[s, 3], steps[s, 10], steps[s, 14]
    fours = n - n % 4
    for i in range(rows):
        to, a = steps[s, 4] + i * steps[s, 5], steps[s, 8] + i * steps[s, 9]
        row = memory[to : to + columns]
        for j in range(columns):
            row[j] = memory[steps[s, 16] + j * steps[s, 19]]
        for k in range(0, fours, 4):
            w, x, y, z = _four(memory, a + k * gap, gap)
            b = steps[s, 12] + k * below
            first, second = memory[b : b + columns], memory[b + below : b + below + columns]
            third, fourth = memory[b + 2 * below :][:columns], memory[b + 3 * below :][:columns]
            for j in range(columns):
                row[j] = row[j] + w * first[j] + x * second[j] + y * third[j] + z * fourth[j]
        for k in range(fours, n):
            b, w = steps[s, 12] + k * below, memory[a + k * gap]
            first = memory[b : b + columns]
            for j in range(columns):
                row[j] += w * first[j]


@kernel
def _four(memory: Numbers, place: int, gap: int) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    return memory[place], memory[place + gap], memory[place + 2 * gap], memory[place + 3 * gap]


@kernel
def _combine(do: int, result: Numbers, a: Numbers, b: Numbers) -> None:
    """`ADD` to `DIVIDE` of numbers [N] without gaps, several at once in a vector of the processor."""
    if do == ADD:
        for k in range(len(result)):
            result[k] = a[k] + b[k]
    elif do == SUBTRACT:
        for k in range(len(result)):
            result[k] = a[k] - b[k]
    elif do == MULTIPLY:
        for k in range(len(result)):
            result[k] = a[k] * b[k]
    else:
        for k in range(len(result)):
            result[k] = a[k] / b[k]


@kernel
def _calculated(do: int, a: np.float32, b: np.float32, c: np.float32, d: np.float32) -> np.float32:
    """One of `ADD` to `ANGLE`."""
    if do == ADD:
        return a + b
    if do == SUBTRACT:
        return a - b
    if do == MULTIPLY:
        return a * b
    if do == DIVIDE:
        return a / b
    if do == COPY:
        return a
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
    made: np.float32
    if do == EXP:
        made = _exp(x)
    elif do == LOG:
        made = np.log(x)
    elif do == SQRT:
        made = np.sqrt(x)
    elif do == TANH:
        made = np.tanh(x)
    elif do == ASINH:
        made = np.arcsinh(x)
    elif do == SIGMOID:
        made = ONE / (ONE + _exp(-x))
    elif do == SILU:
        made = _silu(x)
    elif do == COSINE:
        made = np.cos(x)
    else:
        made = np.sin(x)
    return made


@kernel
def _exp(x: np.float32) -> np.float32:
    """E to the ``x``, to 1e-7 of it: Taylor's series within ln 2 / 2, times a power of two.

    Unlike with a library's, a loop over it takes several numbers at once, and answers are those of any machine.
    """
    within = LOWEST if x < LOWEST else HIGHEST if x > HIGHEST else x
    twos = np.floor(within * PER_LN_2 + HALF)
    r = within - twos * LN_2 - twos * REST_OF_LN_2
    series = ((((((T7 * r + T6) * r + T5) * r + T4) * r + T3) * r + T2) * r + ONE) * r + ONE
    made: np.float32 = series * np.int32((np.int32(twos) + np.int32(127)) << np.int32(23)).view(np.float32)
    return made


@kernel
def _silu(x: np.float32) -> np.float32:
    return x / (ONE + _exp(-x))


@kernel
def _gate(row: Numbers, a: Numbers) -> None:
    """`SILU` of numbers without gaps."""
    for k in range(len(row)):
        row[k] = _silu(a[k])


@kernel
def _sum(memory: Numbers, n: int, a: int, gap: int) -> np.float32:
    total = np.float32(0.0)
    for k in range(n):
        total += memory[a + k * gap]
    return total


@kernel
def _share(row: Numbers, a: Numbers) -> None:
    """`SHARES` (softmax)."""
    most, total = a[0], np.float32(0.0)
    for k in range(len(row)):
        most = max(most, a[k])
    for k in range(len(row)):
        row[k] = _exp(a[k] - most)
    for k in range(len(row)):
        total += row[k]
    for k in range(len(row)):
        row[k] /= total


@kernel
def _normalise(row: Numbers, a: Numbers, gain: Numbers, bias: Numbers) -> None:
    """`NORMAL` (layer normalisation)."""
    n, total, variance = np.float32(len(row)), np.float32(0.0), np.float32(0.0)
    for k in range(len(row)):
        total += a[k]
    for k in range(len(row)):
        row[k] = a[k] - total / n
        variance += row[k] * row[k]
    std = np.sqrt(variance / n + LEAST_VARIANCE)
    for k in range(len(row)):
        row[k] = row[k] / std * gain[k] + bias[k]
