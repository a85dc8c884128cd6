// Data association: of which person the boxes of a column are.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "window.hpp"

namespace vbbench {

/// Boxes from a frame on that go to another person.
struct Reassignment {
  int from;     ///< index of the person who has them
  int to;       ///< of the person whom they show; −1: one who is not known yet
  int node;     ///< of the first box in the path of the person who has them
  Person path;  ///< of the person whom they show, with these boxes
};

/// Finds identity switches, and people who have got another column.
class Association {
 public:
  void start() {
    switches_ = 1.0;
    kept_ = 100.0;
  }

  template <class Archive>
  void archive(Archive& a) {
    a(switches_), a(kept_);
  }

  /// Assigns boxes that surprise, and those of paths that began a short time ago, to the paths that they continue most
  /// probably: one's own, another that has ended or whose box surprises, or none.
  std::vector<Reassignment> associate(const Window& window, const Model& learned) {
    Model model = learned;
    for (int c = 0; c < 3; ++c) model.people.noise.share[c] *= std::sqrt(model.people.noise.excess[c]);
    const int newest = static_cast<int>(window.frames.size()) - 1;
    std::vector<Part> heads, tails;
    int again = 0;
    for (int p = 0; p < static_cast<int>(window.people.size()); ++p) {
      const Person& person = window.people[p];
      if (person.last() < newest || !is_examined(person.nodes.back())) continue;
      again += person.frames() > 1;
      double least = continuity() + kClear;
      Part head, tail;
      const std::array<double, kLate> surprise = surprises(window, person, model);
      const int last = person.frames() - 1;
      for (int node = last; node > std::max(0, last - kLate); --node) {
        if (person.nodes[node].given) break;
        if (!is_examined(person.nodes[node]) || surprise[last - node] < kDoubt) continue;
        Part earlier{p, before(person, node)}, later{p, after(person, node)};
        const double nats = link(window, model, earlier, later, 1).nats;
        if (nats >= least) continue;
        least = nats;
        head = std::move(earlier);
        tail = std::move(later);
      }
      if (head.person >= 0) {
        heads.push_back({p, std::move(head.path)});
        tails.push_back({p, std::move(tail.path)});
      } else if (is_young(person)) {
        tails.push_back({p, person});
      }
    }
    std::vector<Link> links;
    for (int p = 0; p < static_cast<int>(window.people.size()) && !tails.empty(); ++p)
      if (window.people[p].last() < newest && window.people[p].frames() > 1) heads.push_back({p, window.people[p]});
    for (int t = 0; t < static_cast<int>(tails.size()); ++t)
      for (int h = 0; h < static_cast<int>(heads.size()); ++h) {
        Part &head = heads[h], &tail = tails[t];
        const bool own = head.person == tail.person;
        if (!own && !is_near(window, model, head.path, tail.path)) continue;
        Link one = link(window, model, head, tail);
        one.head = h;
        one.tail = t;
        if (one.nats > (own ? 0.0 : kSurer)) links.push_back(std::move(one));
      }
    std::stable_sort(links.begin(), links.end(), [](const Link& a, const Link& b) { return a.nats > b.nats; });
    std::vector<Reassignment> found;
    int switched = 0;
    for (Link& one : links) {
      Part &head = heads[one.head], &tail = tails[one.tail];
      if (head.assigned || tail.assigned) continue;
      head.assigned = tail.assigned = true;
      if (head.person == tail.person) continue;
      const int node = tail.path.first - window.people[tail.person].first;
      switched += node > 0;
      found.push_back({tail.person, head.person, node, std::move(one.path)});
    }
    for (Part& tail : tails) {
      const int node = tail.path.first - window.people[tail.person].first;
      if (tail.assigned || node == 0) continue;
      ++switched;
      found.push_back({tail.person, -1, node, placed(window, tail.path)});
    }
    if (switched > 0 && 2 * switched >= again) {  // then the camera's motion is the likelier cause
      found.clear();
      switched = 0;
    }
    switches_ += switched;
    kept_ += again;
    return found;
  }

  /// A path up to a node, without it.
  static Person before(const Person& person, int node) {
    Person first = person;
    first.column = -1;
    first.nodes.resize(node);
    std::erase_if(first.between, [&](const Between& one) { return one.node >= node; });
    return first;
  }

 private:
  static constexpr double kClear = 3.0;   ///< nats of evidence for one's own path above which no other is tried
  static constexpr double kDoubt = 6.0;   ///< squared σ from which a box is examined
  static constexpr int kLate = 3;         ///< newest key frames with which a path may begin or continue another
  static constexpr double kArea = 300.0;  ///< m² in which people are who are not known yet
  static constexpr int kRounds = 8;
  static constexpr double kLogTwoPi = 1.8378770664093453;

  /// A path that ended, or one that begins.
  struct Part {
    int person = -1;
    Person path;
    double evidence = NAN;  ///< ln of the marginal likelihood, up to constants of the parts of a link
    bool assigned = false;
  };

  /// A path that ended with one that begins, and the log odds that both are of one person.
  struct Link {
    double nats;
    Person path;
    int head = -1, tail = -1;
  };

  static bool is_examined(const Node& node) { return node.seen && !node.given && !node.box.cut; }

  static bool is_young(const Person& person) {
    return person.first > 0 && person.frames() <= kLate && !person.prior.any &&
           std::none_of(person.nodes.begin(), person.nodes.end(), [](const Node& node) { return node.given; });
  }

  /// Whether a person can have gone from the end of one path to the bearing at which another begins.
  static bool is_near(const Window& window, const Model& model, const Person& head, const Person& tail) {
    if (head.last() >= tail.first) return false;
    const auto& camera = window.frames[tail.first].at;
    const auto& end = head.nodes.back().at;
    const double time = (tail.first - head.last() + 1) * model.people.walk.dt;
    const double dx = end[0] - camera[0], dy = end[1] - camera[1];
    const double off = wrap(elementary::atan2(dy, dx) - camera[2] + tail.nodes[0].box.azimuth);
    return std::abs(off) * elementary::hypot(dx, dy) < model.people.pace.running * time;
  }

  /// Log odds that a column goes on to show its person.
  double continuity() const { return elementary::log(kept_ / switches_); }

  /// Joins two parts, and compares the evidence of one person with that of two (Bayes factor).
  Link link(const Window& window, const Model& model, Part& head, Part& tail, int rounds = kRounds) {
    if (std::isnan(head.evidence)) {
      Person path = head.path;
      head.evidence = evidence(window, model, path, rounds);
    }
    if (std::isnan(tail.evidence)) {  // with the priors of place, velocity and height of a new person
      Person path = placed(window, tail.path);
      tail.evidence = evidence(window, model, path, rounds) - elementary::log(kArea) - elementary::log(path.height_std);
      if (path.frames() > 1)
        tail.evidence -= kLogTwoPi + 2.0 * elementary::log(model.people.pace.walking * model.people.walk.dt);
    }
    Link one{0.0, joined(head.path, tail.path)};
    const bool same_column = head.path.nodes.back().column == tail.path.column;
    one.nats =
        evidence(window, model, one.path, rounds) - head.evidence - tail.evidence + (same_column ? continuity() : 0.0);
    if (!std::isfinite(one.nats)) one.nats = same_column ? INFINITY : -INFINITY;
    return one;
  }

  /// The two paths as one, on a straight line between them.
  static Person joined(const Person& head, const Person& tail) {
    Person one = head;
    while (one.frames() > 1 && !one.nodes.back().seen) one.nodes.pop_back();
    std::erase_if(one.between, [&](const Between& shown) { return shown.node >= one.frames(); });
    const std::array<double, 2> from = one.nodes.back().at, to = tail.nodes[0].at;
    const int steps = tail.first - one.last();
    for (int i = 1; i < steps; ++i) {
      Node node;
      for (int a = 0; a < 2; ++a) node.at[a] = from[a] + (to[a] - from[a]) * i / steps;
      one.nodes.push_back(node);
    }
    for (Between shown : tail.between) {
      shown.node += one.frames();
      one.between.push_back(shown);
    }
    one.nodes.insert(one.nodes.end(), tail.nodes.begin(), tail.nodes.end());
    one.column = tail.column;
    one.squares += tail.squares;
    one.count += tail.count;
    return one;
  }

  /// A path from a node on, of a person about whom nothing else is known.
  static Person after(const Person& person, int node) {
    Person second;
    second.column = person.column;
    second.first = person.first + node;
    second.nodes.assign(person.nodes.begin() + node, person.nodes.end());
    for (Node& one : second.nodes) one.growth = 0.0;
    for (const Between& one : person.between) {
      if (one.node <= node) continue;
      second.between.push_back(one);
      second.between.back().node -= node;
    }
    second.variance = person.variance;
    second.log_height = second.height_mean = person.height_mean;
    second.height_std = person.height_std;
    return second;
  }

  /// The path where its first box places a person of its height.
  static Person placed(const Window& window, const Person& person) {
    Person moved = person;
    const std::array<double, 2>& from = person.nodes[0].at;
    const auto to = window.placed(person.nodes[0].box, person.log_height, window.frames[person.first]);
    for (Node& node : moved.nodes)
      for (int a = 0; a < 2; ++a) node.at[a] += to[a] - from[a];
    return moved;
  }

  /// Sums of squares of the whitened residuals of a person's newest nodes, the newest one first.
  static std::array<double, kLate> surprises(const Window& window, const Person& person, const Model& model) {
    std::array<double, kLate> sum{};
    const int last = person.frames() - 1;
    const double scale = 1.0 / (model.people.walk.sigma * model.people.walk.sigma);
    person_rows(person, window.frames, window.calibration, model.people, RowVisitor([&](const Row& row) {
                  if (row.cue >= 0 || row.walk) sum[last - row.node] += row.e * row.e * (row.walk ? scale : 1.0);
                }),
                {std::max(0, last - kLate + 1), last});
    return sum;
  }

  /// Minimises the cost of a path at the present camera and calibration in so many `rounds`; returns ln of the marginal
  /// likelihood of its boxes by Laplace's approximation, −∞ if the system is not positive definite.
  double evidence(const Window& window, const Model& model, Person& person, int rounds) {
    Reduced rest;
    const std::vector<double> none(kGlobals, 0.0);
    int walks = 0;
    for (int i = 2; i < person.frames(); ++i) walks += !person.nodes[i].walk_absorbed;
    double least = INFINITY, found = -INFINITY;
    for (int round = 0; round < rounds; ++round) {
      const double cost = window.linearise_alone(person, model, elimination_, rest);
      if (!(cost < least)) {
        if (round > 0) person.move(step_, -1.0);  // the last step raised the cost
        break;
      }
      if (!elimination_.eliminate(rest)) break;
      const double gain = elimination_.solve_right();
      least = cost;
      found = gain - cost - 0.5 * elimination_.log_determinant() + kLogTwoPi * (person.frames() - walks);
      if (gain < 0.1) break;
      elimination_.back_substitute(none, step_);
      person.move(step_);
    }
    return found;
  }

  double switches_ = 1.0, kept_ = 100.0;
  Elimination elimination_;
  std::vector<double> step_;
};

}  // namespace vbbench
