"""A robot among people, simulated apart from the tiers: stepping bodies, a tracker's boxes, wheels, a camera that nods.

It shares no code with the generators: people walk to goals and keep away from one another, bodies are points whose feet
swing, boxes are what surrounds the points. How many people the tracker finds and how far the robot drives are those of
an outside simulator: 5 to 6 boxes a frame of 70 people, 2 to 3 of 30, 49 m in 60 s.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.geometry import FloatArray, IntArray

STEP = 1.0 / 30.0
"""s, of the simulation."""
WIDTH, HEIGHT, FOCAL, K1 = 1280, 720, 650.0, -0.12
"""px, px, px and without unit, of the camera."""
WIDEST = 1.4
"""Tangent of the widest angle that the lens shows."""
MOUNT, TILT, NOD = 1.1, -0.02, 0.003
"""m above ground; rad by which the camera looks down, which its file does not have; rad of nodding."""
SMALLEST, SHOWN = 80.0, 0.45
"""px of height, and the share of a box that must show, below which nobody is detected."""
PACE = 0.85
"""m/s of the robot on a straight way."""
MISSED = 0.03
"""Share of visible people whom the tracker misses in a frame."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What is simulated.

    Parameters
    ----------
    people : how many walk on the square.
    seconds : how long it lasts.
    rate : frames per second.
    odometry : whether wheels measure.
    noise : standard deviation of a box's borders, as a share of its height.
    memory : s over which these errors are correlated.
    square : m, side of the square on which all walk.
    """

    people: int = 70
    seconds: float = 60.0
    rate: float = 15.0
    odometry: bool = True
    noise: float = 0.03
    memory: float = 0.2
    square: float = 56.0


@dataclass(frozen=True, kw_only=True)
class Truth:
    """Times [T], robot poses [T, 3], people [T, N, 2], headings, phases of steps and speeds [T, N], heights [N]."""

    times: FloatArray
    poses: FloatArray
    people: FloatArray
    headings: FloatArray
    phases: FloatArray
    speeds: FloatArray
    heights: FloatArray


def robot_path(drive: Drive, random: np.random.Generator) -> FloatArray:
    """Poses [T, 3] at `STEP`: goes to points of the square in turn, slows in bends, stops at times."""
    half = 0.5 * drive.square - 6.0
    count = round(drive.seconds / STEP) + 1
    poses = np.zeros((count, 3))
    x, y, yaw, speed, turn = -0.6 * half, random.uniform(-4, 4), random.uniform(-0.4, 0.4), 0.5, 0.0
    goal, rest = random.uniform(-half, half, 2), 0.0
    for t in range(count):
        poses[t] = x, y, yaw
        if np.hypot(goal[0] - x, goal[1] - y) < 1.5:
            goal = random.uniform(-half, half, 2)
            rest = random.uniform(1.0, 4.0) if random.random() < 0.4 else 0.0
        off = (np.arctan2(goal[1] - y, goal[0] - x) - yaw + np.pi) % (2 * np.pi) - np.pi
        wanted = 0.0 if rest > 0.0 else PACE * np.exp(-1.5 * abs(off)) + 0.05
        rest -= STEP
        speed += np.clip(wanted - speed, -0.8 * STEP, 0.5 * STEP)
        turn += np.clip(np.clip(1.2 * off, -0.7, 0.7) * (speed > 0.05) - turn, -1.5 * STEP, 1.5 * STEP)
        yaw += turn * STEP
        x, y = x + speed * np.cos(yaw) * STEP, y + speed * np.sin(yaw) * STEP
    return poses


def crowd(drive: Drive, poses: FloatArray, random: np.random.Generator) -> Truth:
    """People who go to goals beyond the square's border, keep apart, and stand in part."""
    count, n, half = len(poses), drive.people, 0.5 * drive.square
    at, goal = random.uniform(-half, half, (n, 2)), random.uniform(-half, half, (n, 2))
    wanted, standing = np.clip(random.normal(1.3, 0.25, n), 0.6, 2.0), random.random(n) < 0.15
    velocity, heading = np.zeros((n, 2)), random.uniform(-np.pi, np.pi, n)
    phase = random.uniform(0, 2 * np.pi, n)
    people, headings, phases, speeds = np.zeros((count, n, 2)), *np.zeros((3, count, n))
    for t in range(count):
        people[t], headings[t], phases[t], speeds[t] = at, heading, phase, np.hypot(*velocity.T)
        towards = goal - at
        distance = np.hypot(*towards.T) + 1e-9
        arrived = distance < 1.0
        goal[arrived] = random.uniform(-half, half, (int(arrived.sum()), 2))
        pace = np.where(standing, 0.0, wanted)
        force = (pace[:, None] * towards / distance[:, None] - velocity) / 0.6
        apart = at[:, None] - np.concatenate([at, poses[t, None, :2]])[None]
        gap = np.hypot(apart[..., 0], apart[..., 1]) + np.pad(np.eye(n) * 1e6, ((0, 0), (0, 1)))
        reach = np.where(np.arange(n + 1) == n, 1.0, 0.6)
        force += ((3.0 * np.exp((reach - gap) / 0.3) / gap)[..., None] * apart).sum(axis=1)
        force += random.normal(0.0, 0.35, (n, 2))
        velocity += np.clip(force, -4, 4) * STEP
        velocity[standing] *= 0.2
        at = at + velocity * STEP
        moving = np.hypot(*velocity.T)
        turned = (np.arctan2(velocity[:, 1], velocity[:, 0]) - heading + np.pi) % (2 * np.pi) - np.pi
        heading = heading + np.where(moving > 0.2, turned, 0.0) * min(1.0, STEP / 0.25)
        phase = phase + 2 * np.pi * STEP * np.clip(0.55 * moving + 0.25, 0.0, 1.1) * (moving > 0.2)
        swap = random.random(n) < STEP / 40.0
        standing = np.where(swap, ~standing & (random.random(n) < 0.2), standing)
    heights = np.clip(random.normal(1.72, 0.09, n), 1.45, 2.0)
    times = np.arange(count) * STEP
    return Truth(
        times=times, poses=poses, people=people, headings=headings, phases=phases, speeds=speeds, heights=heights
    )


def bodies(truth: Truth, t: int) -> FloatArray:
    """Points [N, P, 3] (x, y, z in m) of everybody's body: two feet that swing, hips, shoulders, a head."""
    at, heading, phase, h = truth.people[t], truth.headings[t], truth.phases[t], truth.heights
    along = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    side = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    stride = 0.16 * h * np.clip(truth.speeds[t] / 1.3, 0.0, 1.3)
    sway = 0.02 * np.sin(phase) * np.clip(truth.speeds[t] / 1.3, 0.0, 1.0)
    bob = 0.02 * np.cos(2 * phase) * np.clip(truth.speeds[t] / 1.3, 0.0, 1.0)
    parts = []

    def point(ahead: FloatArray | float, left: FloatArray | float, up: FloatArray) -> None:
        place = at + np.multiply(ahead, np.ones(len(h)))[:, None] * along
        place = place + (np.multiply(left, np.ones(len(h))) + sway)[:, None] * side
        parts.append(np.concatenate([place, up[:, None]], axis=-1))

    for leg in (1.0, -1.0):
        swing = leg * np.sin(phase)
        lift = 0.08 * np.clip(leg * np.cos(phase), 0.0, 1.0) * np.clip(truth.speeds[t] / 1.3, 0.0, 1.0)
        for toe in (-0.08, 0.18):
            for width in (-0.05, 0.05):
                point(stride * swing + toe, 0.1 * leg + width, lift)
        point(0.5 * stride * swing, 0.1 * leg, 0.28 * h)
        point(-0.7 * stride * swing, 0.26 * leg, 0.45 * h + bob)  # a hand
        point(0.0, 0.22 * leg, 0.80 * h + bob)
        point(0.1, 0.12 * leg, 0.55 * h + bob)
        point(-0.12, 0.12 * leg, 0.55 * h + bob)
    for around in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        point(0.09 * np.cos(around), 0.08 * np.sin(around), 0.93 * h + bob)
    point(0.0, 0.0, h + bob)
    return np.stack(parts, axis=1)


def pixels(points: FloatArray, pose: FloatArray, pitch: float, roll: float) -> tuple[FloatArray, FloatArray]:
    """Distorted pixels [..., 2] and depths [...] of points [..., 3] from a ``pose``; −1 where the lens sees none."""
    dx, dy = points[..., 0] - pose[0], points[..., 1] - pose[1]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    forward, right, down = c * dx + s * dy, s * dx - c * dy, MOUNT - points[..., 2]
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    depth, lower = cp * forward - sp * down, cp * down + sp * forward
    across, below = cr * right + sr * lower, cr * lower - sr * right
    x, y = across / np.maximum(depth, 1e-3), below / np.maximum(depth, 1e-3)
    bend = 1.0 + K1 * (x * x + y * y)
    depth = np.where(x * x + y * y < WIDEST**2, depth, -1.0)  # farther out the polynomial folds back
    return np.stack([0.5 * WIDTH + FOCAL * bend * x, 0.5 * HEIGHT + FOCAL * bend * y], axis=-1), depth


def correlated(shape: tuple[int, ...], dt: float, memory: float, random: np.random.Generator) -> FloatArray:
    """Errors [T, ...] of deviation 1 that are correlated over ``memory`` s."""
    keep = np.exp(-dt / memory)
    out = random.normal(size=shape)
    for t in range(1, shape[0]):
        out[t] = keep * out[t - 1] + np.sqrt(1 - keep * keep) * out[t]
    return out


def boxes_of(truth: Truth, frames: IntArray, drive: Drive, random: np.random.Generator) -> list[FloatArray]:
    """For each frame the rows (id, left, top, width, height, score) of a tracker, in distorted px."""
    dt, n = 1.0 / drive.rate, len(truth.heights)
    errors = correlated((len(frames), n, 4), dt, drive.memory, random)
    pitch = TILT + NOD * correlated((len(frames),), dt, 0.4, random)
    roll = NOD * correlated((len(frames),), dt, 0.4, random)
    names, lost = np.arange(n), np.zeros(n)
    found = []
    for row, t in enumerate(frames):
        seen, depth = pixels(bodies(truth, t), truth.poses[t], pitch[row], roll[row])
        low, high = seen.min(axis=1), seen.max(axis=1)
        ahead = depth.min(axis=1) > 0.3
        size = (high - low)[:, 1]
        clipped = np.stack([np.clip(low, 0, None), np.minimum(high, (WIDTH, HEIGHT))])
        part = np.prod(np.clip(clipped[1] - clipped[0], 0, None), axis=-1) / np.maximum(np.prod(high - low, axis=-1), 1)
        usable = ahead & (part > 0.4)
        order = np.argsort(depth.mean(axis=1))
        rows = []
        drawn: list[FloatArray] = []
        for k in order:
            if not usable[k]:
                continue
            box = np.concatenate([clipped[0, k], clipped[1, k]])
            hidden = covered(box, drawn)
            drawn.append(box)
            known = size[k] > SMALLEST and 1.0 - hidden > SHOWN and random.random() > MISSED
            lost[k] = 0.0 if known else lost[k] + dt
            if not known:
                continue
            if lost[k] > 1.5 or random.random() < 0.0003 * 15 / drive.rate:
                names[k] = names.max() + 1  # a new track
            e = drive.noise * size[k] * errors[row, k] * np.array([0.5, 0.5, 1.0, 1.0]) / np.sqrt(2.0)
            left, top, right, bottom = box[0] + e[0], box[1] + e[2], box[2] + e[1], box[3] + e[3]
            rows.append((names[k], left, top, right - left, bottom - top, 1.0 - 0.5 * hidden, k))
        for k in np.flatnonzero(~usable):
            lost[k] += dt
            if lost[k] > 1.5:
                names[k] = names.max() + 1
                lost[k] = -1e9
        found.append(np.array(rows).reshape(-1, 7))
    return found


def covered(box: FloatArray, nearer: list[FloatArray]) -> float:
    """Share of a box's middle column strip that boxes of nearer people hide."""
    if not nearer:
        return 0.0
    rows = np.linspace(box[1], box[3], 24)
    columns = np.linspace(0.7 * box[0] + 0.3 * box[2], 0.3 * box[0] + 0.7 * box[2], 7)
    hidden = np.zeros((24, 7), bool)
    for other in nearer:
        inset = 0.12 * (other[2] - other[0])
        hidden |= ((rows > other[1]) & (rows < other[3]))[:, None] & (
            (columns > other[0] + inset) & (columns < other[2] - inset)
        )
    return float(hidden.mean())


def write(folder: Path, drive: Drive, seed: int) -> Path:
    """Simulate a drive and write it as an ``own`` recording with truth; returns the folder."""
    random = np.random.default_rng([seed, drive.people])
    truth = crowd(drive, robot_path(drive, random), random)
    every = round(1.0 / drive.rate / STEP)
    frames = np.arange(0, len(truth.times), every)
    found = boxes_of(truth, frames, drive, np.random.default_rng([seed, drive.people, 1]))
    folder.mkdir(parents=True, exist_ok=True)
    camera = [
        'model = "perspective"',
        f"width = {WIDTH}",
        f"height = {HEIGHT}",
        f"focal = {FOCAL}",
        f"mount_height = {MOUNT}",
        f"fps = {drive.rate:g}",
        "[distortion]",
        f"k1 = {K1}",
        "k2 = 0.0",
        "p1 = 0.0",
        "p2 = 0.0",
    ]
    (folder / "camera.toml").write_text("\n".join(camera) + "\n")
    lines = ["time,id,left,top,width,height,score"]
    people = ["time,id,x,y,height"]
    for t, rows in zip(frames, found, strict=True):
        for name, left, top, width, height, score, k in rows:
            lines.append(f"{truth.times[t]:.5f},{int(name)},{left:.2f},{top:.2f},{width:.2f},{height:.2f},{score:.3f}")
            x, y = truth.people[t, int(k)]
            people.append(f"{truth.times[t]:.5f},{int(name)},{x:.4f},{y:.4f},{truth.heights[int(k)]:.3f}")
    (folder / "boxes.csv").write_text("\n".join(lines) + "\n")
    (folder / "people.csv").write_text("\n".join(people) + "\n")
    (folder / "poses.txt").write_text(tum(truth.times[frames], truth.poses[frames]))
    if drive.odometry:
        (folder / "odometry.txt").write_text(tum(truth.times[frames], wheels(truth.poses, every, random)))
    return folder


def wheels(poses: FloatArray, every: int, random: np.random.Generator) -> FloatArray:
    """Poses [T, 3] as wheels have them: 1.5 % error of scale, 2 % of turn, and white noise."""
    scale, turning = 1.0 + 0.015 * random.normal(), 1.0 + 0.02 * random.normal()
    steps = np.diff(poses, axis=0)
    ahead = np.cos(poses[:-1, 2]) * steps[:, 0] + np.sin(poses[:-1, 2]) * steps[:, 1]
    ahead = scale * ahead + 0.004 * np.sqrt(STEP) * random.normal(size=len(ahead)) * (np.abs(ahead) > 1e-5)
    turn = turning * steps[:, 2] + 0.004 * np.sqrt(STEP) * random.normal(size=len(ahead)) * (np.abs(ahead) > 1e-5)
    yaw = np.concatenate([[poses[0, 2]], poses[0, 2] + np.cumsum(turn)])
    x = poses[0, 0] + np.concatenate([[0.0], np.cumsum(ahead * np.cos(yaw[:-1]))])
    y = poses[0, 1] + np.concatenate([[0.0], np.cumsum(ahead * np.sin(yaw[:-1]))])
    return np.stack([x, y, yaw], axis=-1)[::every]


def tum(times: FloatArray, poses: FloatArray) -> str:
    """TUM lines of planar poses [T, 3]."""
    return "".join(
        f"{time:.5f} {x:.6f} {y:.6f} 0 0 0 {np.sin(0.5 * yaw):.9f} {np.cos(0.5 * yaw):.9f}\n"
        for time, (x, y, yaw) in zip(times.tolist(), poses.tolist(), strict=True)
    )
