#include "window.hpp"

namespace vbbench {

template <class Visit>
double Window::visit_person(const Person& person, const Model& model, Visit&& visit) const {
  CostSum sum;
  const auto both = [&](const Row& row) {
    visit(row);
    sum.add(row);
  };
  person_rows(person, frames, calibration, model.people, both);
  height_row(person, model.people, both);
  return sum.sum() + Elimination::prior_cost(person, calibration);
}

double Window::cost(const Model& model) {
  double sum = 0.0;
  for (const Person& person : people) sum += visit_person(person, model, [](const Row&) {});
  return sum + camera_cost(model) + calibration_cost();
}

Solution Window::solve(const Model& model, int rounds, double least, bool factorised) {
  Solution solution;
  double damping = kDamping, last = least;
  bool ready = factorised;  // factors and gradient
  if (ready) differentiate(model, least);
  const bool uncertain = calibration.sway_std[0] > 0.0;  // of a known calibration, factors fit the next step less
  for (int round = 0; round < rounds; ++round) {
    const bool again = ready && round > 0;
    if (!ready && !linearise(model, damping)) {
      damping = std::max(10.0 * damping, 1e-4);
      continue;
    }
    solution.cost = cost_;
    ++solution.steps;
    save();
    const bool short_enough = apply();
    const bool prepared = !again && (uncertain || held > 0);  // for the next step
    if (prepared) differentiate(model, least);
    const double now = prepared ? cost_ : cost(model);
    ready = false;
    if (!std::isfinite(now) || now > solution.cost + 1e-9 || !short_enough) {
      restore();
      if (again) continue;
      damping = std::max(10.0 * damping, 1e-4);
      if (damping > 1e4) break;
      continue;
    }
    const double gain = solution.cost - now;
    solution.cost = now;
    damping = std::max(0.1 * damping, kDamping);
    if (gain < least || gain * gain < least * last || (factorised && prepared && predicted_ < least)) return solution;
    ready = uncertain && (prepared || gain < kSlow * last);
    if (again && ready) differentiate(model, least);
    last = gain;
  }
  solution.cost = cost(model);  // the posteriors of the modes are those of the solution
  return solution;
}

Solution Window::solve_changed(const Model& model, int rounds, double least, const std::vector<int>& changed) {
  bool factorised = std::isfinite(damping_);
  Reduced rest;  // the reduced system keeps their former part
  rest.reset(layout_.size());
  double cost = 0.0;
  for (const int p : changed) factorised = factorised && eliminate(p, model, damping_, rest, cost);
  return solve(model, rounds, least, factorised);
}

std::array<double, 2> Window::innovations(const Model& model, std::size_t p, int frame) {
  std::array<double, 2> sum{};
  const Person& person = people[p];
  if (frame < person.first || frame > person.last() || !std::isfinite(damping_)) return sum;
  eliminations_[p].invert(std::max(0, frame - person.first - kReach));
  person_rows(person, frames, calibration, model.people, RowVisitor([&](const Row& row) {
                if (!row.walk) return;
                sum[0] += row.w * row.e * row.e * person.variance;
                sum[1] += std::max(0.0, 1.0 - eliminations_[p].leverage(row));
              }),
              {frame - person.first, frame - person.first, false});
  return sum;
}

bool Window::weigh_learned(const Model& model, int frame) {
  if (!std::isfinite(damping_)) return false;
  const int size = layout_.size(), count = padded(3 * static_cast<int>(people.size()));
  Matrix reduced(size, count);
  std::vector<double> weights(count, 0.0);
  for (std::size_t p = 0; p < people.size(); ++p) {
    Person& person = people[p];
    if (frame < person.first || frame > person.last()) continue;
    Node& node = person.nodes[frame - person.first];
    node.leverage.fill(0.0);
    person_rows(person, frames, calibration, model.people, RowVisitor([&](const Row& row) {
                  if (row.cue < 0) return;
                  weights[3 * p + row.cue] = row.w;
                  node.leverage[row.cue] =
                      row.w * eliminations_[p].eliminated(row, reduced[0] + 3 * p + row.cue, count);
                }),
                {frame - person.first, frame - person.first});
  }
  for (int g = 0; g < kGlobals; ++g)
    if (!calibration.free[g]) std::fill_n(reduced[g], count, 0.0);
  solve_lower(reduced_.factor(), size, reduced_.lines.cols(), reduced[0], count);
  for (std::size_t p = 0; p < people.size(); ++p) {
    if (frame < people[p].first || frame > people[p].last()) continue;
    Node& node = people[p].nodes[frame - people[p].first];
    for (int cue = 0; cue < 3; ++cue)
      for (int i = 0; i < size; ++i) {
        const double x = reduced[i][3 * p + cue];
        node.leverage[cue] += weights[3 * p + cue] * x * x;
      }
  }
  return true;
}

bool Window::covariances(const Model& model, int frame, bool fresh, Covariances& out) {
  if (!(fresh && is_linearised()) && !linearise(model, 0.0, static_cast<int>(frames.size()))) return false;
  const int newest = static_cast<int>(frames.size()) - 1, next = std::min(kHeld, newest);
  // Columns of the unknowns that are wanted: two poses, odometry, places; then U⁻ᵀ of these.
  const int places = 8, count = padded(places + 2 * static_cast<int>(people.size()));
  Matrix wanted(layout_.size(), count);
  const auto want = [&](int unknown, int column) {
    if (unknown >= 0) wanted[unknown][column] = 1.0;
  };
  for (int c = 0; c < 3; ++c) {
    want(layout_.camera(kFrame * frame + c), c);
    want(layout_.camera(kFrame * next + c), 3 + c);
  }
  for (int g = 0; g < 2; ++g) want(kOdometryScale + g, 6 + g);
  out.places.assign(people.size(), {NAN, NAN, NAN});
  for (std::size_t p = 0; p < people.size(); ++p) {
    const int node = frame - people[p].first;
    if (node >= 0 && node < people[p].frames())
      out.places[p] = eliminations_[p].place_covariance(node, wanted[0] + places + 2 * p, count);
  }
  for (int g = 0; g < kGlobals; ++g)
    if (!calibration.free[g]) std::fill_n(wanted[g], count, 0.0);
  solve_lower(reduced_.factor(), layout_.size(), reduced_.lines.cols(), wanted[0], count);
  for (int i = 0; i < layout_.size(); ++i) {
    const double* row = wanted[i];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        out.pose[a][b] += row[a] * row[b];
        out.next[a][b] += row[3 + a] * row[3 + b];
      }
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) out.odometry[a][b] += row[6 + a] * row[6 + b];
    for (std::size_t p = 0; p < people.size(); ++p) {
      const double x = row[places + 2 * p], y = row[places + 2 * p + 1];
      out.places[p][0] += x * x;
      out.places[p][1] += x * y;
      out.places[p][2] += y * y;
    }
  }
  return true;
}

void Window::marginalise(const Model& model) {
  mode_costs(frames, model.motion, trial, costs_);
  if (costs_.size() > 1) {
    weigh(mode_prior, costs_[0]);
    mode_prior = model.motion.after(mode_prior);
  }
  for (std::size_t p = people.size(); p-- > 0;) {
    Person& person = people[p];
    if (person.first > 0) {
      --person.first;
      continue;
    }
    absorb(person, model);
    person.nodes.erase(person.nodes.begin());
    bool known = false;
    for (const Node& node : person.nodes) known = known || node.seen || node.given;
    if (!known) {
      retire(person);
      people.erase(people.begin() + static_cast<std::ptrdiff_t>(p));
    }
  }
  Frame& next = frames[1];
  next.left = std::min(frames[0].left + 1, static_cast<int>(next.past.size()));
  for (int j = next.left - 1; j > 0; --j) next.past[j] = frames[0].past[j - 1];
  std::copy_n(frames[0].at.begin(), kPose, next.past[0].begin());
  frames.erase(frames.begin());
  held = kHeld;
}

void Window::restart() {
  const int newest = static_cast<int>(frames.size()) - 1;
  for (std::size_t p = people.size(); p-- > 0;) {
    Person& person = people[p];
    if (person.last() != newest) {
      if (person.prior.any) retire(person);
      people.erase(people.begin() + static_cast<std::ptrdiff_t>(p));
      continue;
    }
    Node last = person.nodes.back();
    last.walk_absorbed = false;
    last.growth = 0.0;
    last.box_absorbed.fill(false);
    person.nodes.assign(1, last);
    person.first = 0;
    person.between.clear();
    person.prior = MarginalPrior();
  }
  frames.erase(frames.begin(), frames.end() - 1);
  frames.front().motion = Motion();
  frames.front().left = 0;
  frames.front().between = 0.0;
  posterior.clear();
  held = 0;
}

bool Window::linearise(const Model& model, double damping, int kept) {
  damping_ = INFINITY;
  layout_.frames = static_cast<int>(frames.size());
  layout_.held = held;
  layout_.kept = kept;
  layout_.unknowns = calibration.sway_std[0] > 0.0 ? kFrame : kPose;
  const int size = layout_.size();
  reduced_.reset(size);
  cost_ = camera_cost(model) + calibration_cost();
  for (std::size_t p = 0; p < people.size(); ++p)
    if (!eliminate(p, model, damping, reduced_, cost_)) return false;
  camera_rows(frames, calibration, model.motion, posterior, model.sway_memory, held,
              [&](const CameraRow& row) { reduced_.add(row, layout_); });
  add_calibration(true);
  for (int g = 0; g < kGlobals; ++g)
    if (!calibration.free[g]) reduced_.fix(g);
  for (int i = 0; i < size; ++i) reduced_.hessian(i, i) += damping * std::abs(reduced_.hessian(i, i)) + 1e-9;
  if (!reduced_.factorise()) return false;
  solve_reduced();
  damping_ = damping;
  return true;
}

double Window::linearise(const Person& person, const Model& model, const Layout& layout, double damping,
                         Elimination& elimination, Reduced& reduced) const {
  elimination.reset(person, layout, damping);
  const double cost = visit_person(person, model, [&](const Row& row) { elimination.add(row, reduced); });
  elimination.add_prior(person, calibration, reduced);
  return cost;
}

bool Window::eliminate(std::size_t p, const Model& model, double damping, Reduced& reduced, double& cost) {
  while (eliminations_.size() <= p) eliminations_.emplace_back();
  Elimination& elimination = eliminations_[p];
  cost += linearise(people[p], model, layout_, damping, elimination, reduced);
  return elimination.eliminate(reduced);
}

double Window::differentiate(std::size_t p, const Model& model) {
  Elimination& elimination = eliminations_[p];
  elimination.clear_right();
  const double cost = visit_person(people[p], model, [&](const Row& row) { elimination.add_right(row, reduced_); });
  elimination.add_prior(people[p], calibration, reduced_, false);
  return cost;
}

void Window::differentiate(const Model& model, double least) {
  double* line = reduced_.lines[0];
  std::fill_n(line, reduced_.lines.cols(), 0.0);
  predicted_ = 0.0;
  cost_ = camera_cost(model) + calibration_cost();
  for (std::size_t p = 0; p < people.size(); ++p) {
    gradient_.assign(line, line + reduced_.lines.cols());
    double cost = differentiate(p, model), own = eliminations_[p].solve_right();
    if (own > least && held > 0) {
      std::copy(gradient_.begin(), gradient_.end(), line);
      minimise_alone(people[p], model, least);
      cost = differentiate(p, model);
      own = eliminations_[p].solve_right();
    }
    cost_ += cost;
    predicted_ += own;
    eliminations_[p].reduce_right(reduced_);
  }
  camera_rows(frames, calibration, model.motion, posterior, model.sway_memory, held,
              [&](const CameraRow& row) { reduced_.add(row, layout_, false); });
  add_calibration(false);
  for (int g = 0; g < kGlobals; ++g)
    if (!calibration.free[g]) reduced_.gradient(g) = 0.0;
  solve_reduced();
  for (int i = 0; i < layout_.size(); ++i) predicted_ += 0.5 * step_[i] * reduced_.gradient(i);
}

void Window::solve_reduced() {
  step_.assign(reduced_.lines[0] + 1, reduced_.lines[0] + 1 + layout_.size());
  solve_both(reduced_.factor(), layout_.size(), reduced_.lines.cols(), step_.data());
}

double Window::linearise_alone(const Person& person, const Model& model, Elimination& alone, Reduced& rest) const {
  Layout layout;
  layout.frames = layout.held = static_cast<int>(frames.size());
  rest.reset(kGlobals);
  return linearise(person, model, layout, 0.0, alone, rest);
}

void Window::minimise_alone(Person& person, const Model& model, double least) {
  Reduced rest;
  const std::vector<double> none(kGlobals, 0.0);
  Person best;
  double cost = INFINITY;
  while (true) {
    const double now = linearise_alone(person, model, alone_, rest), gain = cost - now;
    if (!(gain > 0.0)) break;
    cost = now;
    if (gain < least || !alone_.eliminate(rest)) return;
    best = person;
    alone_.back_substitute(none, own_);
    person.move(own_);
  }
  if (std::isfinite(cost)) person = best;
}

bool Window::apply() {
  double longest = 0.0, longest_way = 0.0;
  for (std::size_t p = 0; p < people.size(); ++p) {
    Person& person = people[p];
    eliminations_[p].back_substitute(step_, own_);
    person.move(own_);
    for (int i = 0; i < eliminations_[p].path; ++i) longest_way = std::max(longest_way, std::abs(own_[i]));
  }
  for (int t = held; t < layout_.frames; ++t) {
    const double* step = &step_[layout_.camera(kFrame * t)];
    longest = std::max(longest, elementary::hypot(step[0], step[1]));
    for (int c = 0; c < layout_.unknowns; ++c) frames[t].at[c] += step[c];
  }
  for (int g = 0; g < kGlobals; ++g)
    if (calibration.free[g]) calibration.at[g] += step_[g];
  return longest <= kLongestStep && longest_way <= kLongestWay;
}

void Window::absorb(Person& person, const Model& model) {
  constexpr int kAll = 2 + kPrior;  // the place that leaves, then what the prior is about
  static thread_local std::array<std::array<double, kAll>, kAll> h;
  std::array<double, kAll> g{};
  for (auto& row : h) row.fill(0.0);
  const auto index = [&](const Variable& v) {
    if (v.kind == Variable::kPath) return v.index;
    if (v.kind == Variable::kHeight) return 2 + kPriorPlaces;
    if (v.kind == Variable::kShared && calibration.free[v.index]) return 3 + kPriorPlaces + v.index;
    return -1;
  };
  const auto add = [&](const Row& row) {
    int at[kSlots], count = 0;
    double by[kSlots];
    row.each(person.first, [&](const Variable& v, double value) {
      const int i = index(v);
      if (i < 0 || value == 0.0) return;
      at[count] = i;
      by[count++] = value;
    });
    for (int a = 0; a < count; ++a) {
      g[at[a]] -= row.w * row.e * by[a];
      for (int b = 0; b < count; ++b) h[at[a]][at[b]] += row.w * by[a] * by[b];
    }
  };
  std::array<bool, 3> chained{};
  person_rows(person, frames, calibration, model.people, RowVisitor([&](const Row& row) {
                if (row.node > row.reach) return;
                add(row);
                if (row.cue >= 0 && row.node == 1) chained[row.cue] = true;
              }),
              {0, kReach});
  height_row(person, model.people, add);
  if (person.prior.any) {
    double off[kPrior];
    Elimination::prior_offsets(person, calibration, off);
    for (int a = 0; a < kPrior; ++a) {
      const int ia = a < kPriorPlaces ? a : a + 2;  // places 0 … kReach − 1 are nodes 0 … kReach − 1
      double gradient = person.prior.vector[a];
      for (int b = 0; b < kPrior; ++b) {
        const int ib = b < kPriorPlaces ? b : b + 2;
        gradient -= person.prior.information[a][b] * off[b];
        h[ia][ib] += person.prior.information[a][b];
      }
      g[ia] += gradient;
    }
  }
  // Schur complement on the place that leaves
  const double a = h[0][0] + 1e-12, b = h[1][0], d = h[1][1] + 1e-12, det = a * d - b * b;
  MarginalPrior prior;
  prior.any = true;
  for (int i = 0; i < kPrior; ++i) {
    const double u = h[i + 2][0], v = h[i + 2][1];
    const double cu = (d * u - b * v) / det, cv = (a * v - b * u) / det;
    for (int j = 0; j < kPrior; ++j) prior.information[i][j] = h[i + 2][j + 2] - cu * h[j + 2][0] - cv * h[j + 2][1];
    prior.vector[i] = g[i + 2] - cu * g[0] - cv * g[1];
  }
  for (int i = 0; i < kPrior; ++i)
    for (int j = 0; j < i; ++j)
      prior.information[i][j] = prior.information[j][i] = 0.5 * (prior.information[i][j] + prior.information[j][i]);
  for (int i = 0; i < kPriorPlaces; ++i)
    prior.about[i] = i / 2 + 1 < person.frames() ? person.nodes[i / 2 + 1].at[i % 2] : 0.0;
  prior.about[kPriorPlaces] = person.log_height;
  for (int i = 0; i < kGlobals; ++i) prior.about[kPriorPlaces + 1 + i] = calibration.at[i];
  person.prior = prior;
  // Factors that reach back to the node are in the prior now.
  for (int i = 1; i <= kReach && i < person.frames(); ++i) person.nodes[i].walk_absorbed = true;
  if (person.frames() > 1) person.nodes[1].box_absorbed = chained;
  std::erase_if(person.between, [](const Between& one) { return one.node <= 1; });
  for (Between& one : person.between) --one.node;
}

void Window::retire(const Person& person) {
  const MarginalPrior& prior = person.prior;
  constexpr int kOwn = kPriorPlaces + 1;  // unknowns of the person
  Matrix own(kOwn, padded(kOwn)), x(kOwn, kGlobals + 1);
  for (int i = 0; i < kOwn; ++i) {
    for (int j = 0; j < kOwn; ++j) own[i][j] = prior.information[i][j];
    own[i][i] += 1e-6;
    for (int c = 0; c < kGlobals; ++c) x[i][c] = prior.information[i][kOwn + c];
    x[i][kGlobals] = prior.vector[i];
  }
  if (!cholesky(own[0], kOwn, own.cols())) return;
  static_assert((kGlobals + 1) % kLane == 0);
  solve_lower(own[0], kOwn, own.cols(), x[0], x.cols());
  for (int a = 0; a < kGlobals; ++a) {
    if (!calibration.free[a]) continue;
    double vector = prior.vector[kOwn + a];
    for (int i = 0; i < kOwn; ++i) vector -= x[i][a] * x[i][kGlobals];
    for (int b = 0; b < kGlobals; ++b) {
      double information = prior.information[kOwn + a][kOwn + b];
      for (int i = 0; i < kOwn; ++i) information -= x[i][a] * x[i][b];
      calibration.information[a][b] += information;
      vector -= information * (calibration.about[b] - prior.about[kOwn + b]);
    }
    calibration.vector[a] += vector;
  }
}

template void person_rows(const Person&, const std::vector<Frame>&, const Calibration&, const PeopleModel&,
                          RowVisitor&&, Nodes);

}  // namespace vbbench
