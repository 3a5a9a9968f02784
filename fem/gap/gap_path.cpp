// SPDX-License-Identifier: Apache-2.0

// The increment as a path: block and history stay, the target moves from the previous pose, lambda = 0, to the load
// step's, lambda = 1. Between status changes all quantities are linear in lambda. Where a law would be violated that
// element alone changes, and the path goes on from there, continuous, back to smaller lambda if need be: Lemke's
// pivoting (Cottle, Pang and Stone, The Linear Complementarity Problem, section 4.4), with a load for its parameter. So
// that no two elements change at once, offsets that fade as lambda grows to 1 are added:
//   gap + (1 - lambda) a >= 0,  n + (1 - lambda) b >= 0,  |t| <= mu (n + (1 - lambda) b)
// with random a > 0 where the previous pose is open, b > 0 where it touches, large enough for it to be the solution at
// lambda = 0.
#include "fem/gap/gap_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace tactel::fem {
namespace {

// A quantity along one piece of the path, from where the piece begins.
struct Line {
  double start = 0, slope = 0;
  Line operator+(Line other) const { return {start + other.start, slope + other.slope}; }
  Line operator-(Line other) const { return {start - other.start, slope - other.slope}; }
};
Line operator*(double factor, Line line) { return {factor * line.start, factor * line.slope}; }

struct Start {
  std::vector<Trial> trial;                  // [columns]
  double depth;                              // mm
  Eigen::VectorXd gap_offset, force_offset;  // a [columns] mm, b [columns] N/mm
};

using Place = Eigen::Vector3d;  // depth, tangential position of the indenter (mm), lambda

struct Piece {
  Place direction;
  std::vector<Line> gap, slip, n, t;  // [columns] mm, N/mm; gap and n with their offsets
  void reverse();
};

struct Change {
  double distance = std::numeric_limits<double>::infinity();
  Eigen::Index element = -1;
  Trial from = Trial::open, to = Trial::open;
};

void draw_offsets(const GapIncrement& increment, double size, Start& start) {
  const GapPose& previous = increment.previous;
  const LoadStep& to = increment.target;
  const double stiffness = increment.system.typical_stiffness();
  const double normal =
      to.normal_is_force ? (to.normal - previous.normal_force.sum()) / stiffness : to.normal - start.depth;
  const double tangential = to.tangential_is_force ? (to.tangential - previous.tangential_force.sum()) / stiffness
                                                   : to.tangential - previous.tangential;
  const double length =
      size * (std::abs(normal) + std::abs(tangential) + 1e-3 * double(previous.state.cwiseAbs().maxCoeff()));
  std::mt19937 generator(1);
  const auto draw = [&](double scale) {
    return scale * (0.5 + static_cast<double>(generator()) / (2.0 * std::mt19937::max()));
  };
  start.gap_offset = start.force_offset = Eigen::VectorXd::Zero(previous.gap.size());
  for (Eigen::Index i = 0; i < previous.gap.size(); ++i) {
    if (!touches(start.trial[i])) {
      start.gap_offset[i] = draw(length) + std::max(0.0, -previous.gap[i]);
    } else {
      const double n = previous.normal_force[i], t = std::abs(previous.tangential_force[i]);
      start.force_offset[i] =
          draw(length * stiffness) + std::max({0.0, -n, increment.mu == 0 ? 0 : t / increment.mu - n});
    }
  }
}

// The previous pose; elements that touch are at rest until the indenter moves. Where none does, the nearest begins to.
Start start_of(const GapIncrement& increment, double size) {
  const Trial resting = increment.mu == 0 ? Trial::slip_plus : Trial::stick;
  Start start{increment.previous.trial, increment.previous.depth, {}, {}};
  for (Trial& trial : start.trial) {
    if (touches(trial)) trial = resting;
  }
  if (std::none_of(start.trial.begin(), start.trial.end(), touches)) {
    Eigen::Index nearest;
    start.depth = increment.height.minCoeff(&nearest);
    start.trial[nearest] = resting;
  }
  draw_offsets(increment, size, start);
  return start;
}

void Piece::reverse() {
  direction = -direction;
  for (auto* lines : {&gap, &slip, &n, &t}) {
    for (Line& line : *lines) line.slope = -line.slope;
  }
}

// The direction in which the place may move: both loads follow lambda. A load that is a force is a sum over `force` [2
// columns, 4], which multiplies (1, depth, tangential, 1 - lambda). Where all elements slip under a given Q, the
// indenter moves at constant lambda.
Place direction_of(const GapIncrement& increment, const Start& start, const Extended& force) {
  const LoadStep& to = increment.target;
  const GapPose& previous = increment.previous;
  Eigen::RowVector4d P = Eigen::RowVector4d::Zero(), Q = P;
  for (Eigen::Index i = 0; i < force.rows(); i += 2) {
    Q += force.row(i).cast<double>();
    P -= force.row(i + 1).cast<double>();
  }
  Place normal(1, 0, start.depth - to.normal), tangential(0, 1, previous.tangential - to.tangential);
  if (to.normal_is_force) normal << P[1], P[2], -P[3] + previous.normal_force.sum() - to.normal;
  if (to.tangential_is_force) tangential << Q[1], Q[2], -Q[3] + previous.tangential_force.sum() - to.tangential;
  return normal.stableNormalized().cross(tangential.stableNormalized());
}

std::optional<Piece> trace(const GapIncrement& increment, const Start& start, const std::vector<Trial>& trial,
                           const Place& place) {
  const int count = int(trial.size());
  Extended right = Extended::Zero(2 * count, 4);
  right.leftCols(3) = right_side(increment, trial);
  for (int i = 0; i < count; ++i) {
    right(2 * i + 1, 3) = touches(trial[i]) ? start.gap_offset[i] : start.force_offset[i];
    if (slips(trial[i])) right(2 * i, 3) = friction_sign(trial[i]) * increment.mu * start.force_offset[i];
  }
  const auto response = increment.system.solve(trial, increment.mu, right);
  if (!response) return std::nullopt;
  const Extended force = increment.system.surface_force(*response);
  Piece piece;
  piece.direction = direction_of(increment, start, force);
  Eigen::Matrix<long double, 4, 2> motion;  // of (1, depth, tangential, 1 - lambda): where it is, where it goes
  motion << 1, 0, place[0], piece.direction[0], place[1], piece.direction[1], 1 - place[2], -piece.direction[2];

  const Extended u = increment.system.surface_displacement(*response) * motion, f = force * motion;
  const Extended before = increment.system.surface_displacement(increment.previous.state);
  const auto line = [](const auto& lines, int k) { return Line{double(lines(k, 0)), double(lines(k, 1))}; };
  const Line depth = line(motion, 1), tangential = line(motion, 2), fading = line(motion, 3);
  for (int i = 0; i < count; ++i) {
    const Line history{double(before(2 * i)) - increment.previous.tangential, 0}, height{increment.height[i], 0};
    piece.gap.push_back(height - depth - line(u, 2 * i + 1) + start.gap_offset[i] * fading);
    piece.slip.push_back(line(u, 2 * i) - tangential - history);
    piece.n.push_back(start.force_offset[i] * fading - line(f, 2 * i + 1));
    piece.t.push_back(line(f, 2 * i));
  }
  return piece;
}

// Quantity that stays >= 0 while an element remains `from` instead of changing to `to`.
Line reserve(const Piece& piece, double mu, Eigen::Index i, Trial from, Trial to) {
  if (from == Trial::open) return piece.gap[i];
  if (from == Trial::stick) return mu * piece.n[i] - friction_sign(to) * piece.t[i];
  return to == Trial::open ? piece.n[i] : -friction_sign(from) * piece.slip[i];
}

std::vector<Trial> alternatives(Trial from, double mu) {
  if (from == Trial::open) return {Trial::slip_plus};  // or slip_minus: decided where it closes
  if (from == Trial::stick) return {Trial::slip_plus, Trial::slip_minus};
  return mu > 0 ? std::vector{Trial::open, Trial::stick} : std::vector{Trial::open};
}

// The first condition to reach its limit.
Change next_change(const Piece& piece, double mu, const std::vector<Trial>& trial) {
  Change change;
  for (Eigen::Index i = 0; i < Eigen::Index(trial.size()); ++i) {
    for (Trial to : alternatives(trial[i], mu)) {
      const Line line = reserve(piece, mu, i, trial[i], to);
      if (!(line.slope < 0)) continue;
      const double distance = std::max(0.0, line.start / -line.slope);  // 0: passed by rounding
      if (distance < change.distance) change = {distance, i, trial[i], to};
    }
  }
  if (change.element >= 0 && change.from == Trial::open && mu > 0) {
    // An element that closes slips against the way it has gone in this increment.
    const Line slip = piece.slip[change.element];
    change.to = slip.start + change.distance * slip.slope > 0 ? Trial::slip_minus : Trial::slip_plus;
  }
  return change;
}

// Distance to lambda = 1, or backwards to lambda = 0; infinite where lambda does not change.
double distance_to_end(const Piece& piece, const Place& place) {
  const double rate = piece.direction[2];
  return rate > 0 ? (1 - place[2]) / rate : rate < 0 ? -place[2] / rate : std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<std::vector<Trial>> follow_path(const GapIncrement& increment, GapSearch& search, double offset_size) {
  const Start start = start_of(increment, offset_size);
  std::vector<Trial> trial = start.trial;
  Place place(start.depth, increment.previous.tangential, 0);
  Change change;
  while (!search.exhausted()) {
    ++search.iterations;
    auto piece = trace(increment, start, trial, place);
    if (!piece) return std::nullopt;
    // The condition that ended the old status is gone; the one that would bring it back starts from 0 and must grow.
    const double growth = change.element < 0
                              ? piece->direction[2]
                              : reserve(*piece, increment.mu, change.element, change.to, change.from).slope;
    if (growth < 0) piece->reverse();
    change = next_change(*piece, increment.mu, trial);
    const double end = distance_to_end(*piece, place);
    if (end <= change.distance) return piece->direction[2] > 0 ? std::optional(trial) : std::nullopt;
    place += change.distance * piece->direction;
    trial[change.element] = change.to;
  }
  return std::nullopt;
}

}  // namespace tactel::fem
