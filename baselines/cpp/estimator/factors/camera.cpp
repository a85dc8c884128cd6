#include "camera.hpp"

namespace vbbench {

/// Writes the last poses up to frame `t`, the newest last, as `EgoMotion` takes them; frames that have left the window
/// count. Returns how many there are.
static int span_of(const std::vector<Frame>& frames, int t, std::array<std::array<double, 3>, kSpan>& poses) {
  const int known = std::min(t + 1 + frames[0].left, kSpan);
  for (int j = 0; j < known; ++j)
    for (int c = 0; c < 3; ++c) poses[kSpan - 1 - j][c] = j <= t ? frames[t - j].at[c] : frames[0].past[j - t - 1][c];
  return known;
}

void mode_costs(const std::vector<Frame>& frames, const EgoMotion& motion, const Trial& trial,
                std::vector<Modes>& costs) {
  costs.clear();
  std::array<std::array<double, 3>, kSpan> poses{};
  for (int t = 1; t < static_cast<int>(frames.size()); ++t) {
    Modes here{};
    if (!frames[t].motion.measured) {
      const int known = span_of(frames, t, poses);
      here = motion.costs(poses, known, frames[t].information);
    }
    for (int m = 0; m < kModes; ++m)
      if (motion.start[m] == 0.0) here[m] = 1e6;
    if (t >= static_cast<int>(frames.size()) - trial.steps)
      for (int m = 0; m < kModes; ++m)
        if (trial.out[m]) here[m] += 1e3;
    costs.push_back(here);
  }
}

void learn_roughness(const std::vector<Frame>& frames, const std::vector<Modes>& posterior, double own,
                     EgoMotion& motion) {
  std::array<std::array<double, 3>, kSpan> poses{};
  for (int round = 0; round < 3; ++round) {
    std::array<double, 3> squares{own, own, own}, count = squares;
    for (int t = 1; t < static_cast<int>(frames.size()); ++t) {
      if (frames[t].motion.measured) continue;
      const int known = span_of(frames, t, poses);
      for (int m = 0; m < kModes; ++m)
        if (posterior[t - 1][m] > 1e-3)
          motion.add_changes(m, poses, known, frames[t].information, posterior[t - 1][m], squares, count);
    }
    for (int a = 0; a < 3; ++a) motion.roughness[a] = std::sqrt(squares[a] / count[a]);
  }
}

void camera_rows(const std::vector<Frame>& frames, const Calibration& calibration, const EgoMotion& motion,
                 const std::vector<Modes>& posterior, double sway_memory, int held,
                 const std::function<void(const CameraRow&)>& visit) {
  const int n = static_cast<int>(frames.size());
  for (int t = held; t < n; ++t) {
    const Frame& frame = frames[t];
    if (frame.given) {
      for (int c = 0; c < 3; ++c) {
        const double off = frame.at[c] - frame.given_pose[c];
        CameraRow row = CameraRow::gaussian(c == 2 ? wrap(off) : off, kGivenPose * kGivenPose);
        row.add(Variable::kCamera, kFrame * t + c, 1.0);
        visit(row);
      }
    }
    for (int c = 0; frame.between > 0.0 && c < 3; ++c) {
      const double s = frame.between;
      const double sigma = (c == 2 ? kBetweenTurn : kBetween) * motion.dt * std::min(s, 1.0 - s);
      CameraRow row =
          CameraRow::gaussian((1.0 - s) * frames[t - 1].at[c] + s * frame.at[c] - frame.between_pose[c], sigma * sigma);
      row.add(Variable::kCamera, kFrame * (t - 1) + c, 1.0 - s);
      row.add(Variable::kCamera, kFrame * t + c, s);
      visit(row);
    }
    for (int c = 0; c < 2; ++c) {  // sway
      const double sigma = calibration.sway_std[c];
      if (sigma <= 0.0) continue;
      const double memory = t > 0 ? sway_memory : 0.0;
      const double e = frame.at[kPose + c] - (t > 0 ? memory * frames[t - 1].at[kPose + c] : 0.0);
      CameraRow row = CameraRow::gaussian(e, sigma * sigma * (1.0 - memory * memory));
      row.add(Variable::kCamera, kFrame * t + kPose + c, 1.0);
      if (t > 0) row.add(Variable::kCamera, kFrame * (t - 1) + kPose + c, -memory);
      visit(row);
    }
    if (t == 0) continue;
    if (frame.motion.measured) {
      using D = Dual<8>;
      std::array<D, 3> before, now;
      for (int c = 0; c < 3; ++c) {
        before[c] = D::variable(frames[t - 1].at[c], c);
        now[c] = D::variable(frame.at[c], 3 + c);
      }
      const D scale = D::variable(calibration.at[kOdometryScale], 6) + 1.0;
      const D turning = D::variable(calibration.at[kOdometryTurn], 7) + 1.0;
      const D x = now[0] - before[0], y = now[1] - before[1], ca = cos(before[2]), sa = sin(before[2]);
      const D off[3] = {scale * (ca * x + sa * y) - D(frame.motion.moved[0]),
                        scale * (ca * y - sa * x) - D(frame.motion.moved[1]),
                        wrap(turning * wrap(now[2] - before[2]) - D(frame.motion.moved[2]))};
      for (int a = 0; a < 3; ++a) {
        D e(0.0);
        for (int b = 0; b <= a; ++b) e = e + frame.motion.root[a][b] * off[b];
        CameraRow row = CameraRow::gaussian(e.v, 1.0);
        for (int c = 0; c < 3; ++c) {
          row.add(Variable::kCamera, kFrame * (t - 1) + c, e.d[c]);
          row.add(Variable::kCamera, kFrame * t + c, e.d[3 + c]);
        }
        row.add(Variable::kShared, kOdometryScale, e.d[6]);
        row.add(Variable::kShared, kOdometryTurn, e.d[7]);
        visit(row);
      }
      continue;
    }
    std::array<std::array<double, 3>, kSpan> poses{};
    const int known = span_of(frames, t, poses);
    std::array<std::array<PoseDual, 3>, kSpan> duals;
    for (int j = 0; j < kSpan; ++j)
      for (int c = 0; c < 3; ++c) duals[j][c] = PoseDual::variable(poses[j][c], 3 * j + c);
    for (int mode = 0; mode < kModes; ++mode) {
      const double share = posterior[t - 1][mode];
      if (share < 1e-6) continue;
      motion.residuals(mode, duals, known, [&](const PoseDual& r, double weight, double, int) {
        CameraRow row;
        row.e = r.v;
        row.w = share * weight;
        for (int j = std::max(kSpan - known, kSpan - 1 - t); j < kSpan; ++j)
          for (int c = 0; c < 3; ++c)
            if (r.d[3 * j + c] != 0.0) row.add(Variable::kCamera, kFrame * (t - (kSpan - 1 - j)) + c, r.d[3 * j + c]);
        visit(row);
      });
    }
  }
}

}  // namespace vbbench
