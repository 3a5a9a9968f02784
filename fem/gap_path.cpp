// The increment as a path: block and history stay, the target moves from the previous pose, lambda = 0, to the load
// step's, lambda = 1. Between status changes all quantities are linear in lambda. Where a law would be violated that
// element alone changes, and the path goes on from there, continuous, back to smaller lambda if need be: Lemke's
// pivoting (Cottle, Pang and Stone, The Linear Complementarity Problem, section 4.4), with a load for its parameter. So
// that no two elements change at once, offsets that fade as lambda grows to 1 are added:
//   gap + (1 - lambda) a >= 0,  n + (1 - lambda) b >= 0,  |t| <= mu (n + (1 - lambda) b)
// with random a > 0 where the previous pose is open, b > 0 where it touches, large enough for it to be the solution at
// lambda = 0.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "fem/gap_increment.h"

namespace tactel::fem {
namespace {

// A quantity along one piece of the path.
struct Line {
  double start = 0, slope = 0;  // value = start + lambda slope
  double at(double lambda) const { return start + lambda * slope; }
  Line operator+(Line other) const { return {start + other.start, slope + other.slope}; }
  Line operator-(Line other) const { return {start - other.start, slope - other.slope}; }
};
Line operator*(double factor, Line line) { return {factor * line.start, factor * line.slope}; }

struct Start {
  std::vector<Trial> trial;                  // [columns]
  double depth;                              // mm
  Eigen::VectorXd gap_offset, force_offset;  // a [columns] mm, b [columns] N/mm
};

struct Piece {
  std::vector<Line> gap, slip, n, t;  // [columns] mm, N/mm; gap and n with their offsets
};

struct Change {
  double lambda;
  Eigen::Index element = -1;
  Trial to = Trial::open;
};

void draw_offsets(const GapIncrement& increment, unsigned seed, Start& start) {
  const GapPose& previous = increment.previous;
  const LoadStep& to = increment.target;
  const double stiffness = increment.block.typical_stiffness();
  const double normal =
      to.normal_is_force ? (to.normal - previous.normal_force.sum()) / stiffness : to.normal - start.depth;
  const double tangential = to.tangential_is_force ? (to.tangential - previous.tangential_force.sum()) / stiffness
                                                   : to.tangential - previous.tangential;
  // Any size would do, since they fade; a small part of the increment keeps the path near that of the load alone.
  const double length =
      1e-3 * (std::abs(normal) + std::abs(tangential) + 1e-3 * previous.displacement.cwiseAbs().maxCoeff());
  std::mt19937 generator(seed);
  const auto draw = [&](double scale) { return scale * (0.5 + generator() / (2.0 * std::mt19937::max())); };
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
Start start_of(const GapIncrement& increment, unsigned seed) {
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
  draw_offsets(increment, seed, start);
  return start;
}

// (1, depth, tangential, 1 - lambda), at lambda = 0 and its slope, [4, 2]; `force` [2 columns, 4] multiplies it.
std::optional<Eigen::Matrix<double, 4, 2>> indenter_motion(const GapIncrement& increment, const Start& start,
                                                           const Eigen::MatrixXd& force) {
  const LoadStep& to = increment.target;
  LoadStep from = to;
  from.normal = to.normal_is_force ? increment.previous.normal_force.sum() : start.depth;
  from.tangential = to.tangential_is_force ? increment.previous.tangential_force.sum() : increment.previous.tangential;
  Eigen::MatrixXd with_offsets = force.leftCols(3);
  with_offsets.col(0) += force.col(3);
  const auto first = indenter_position(from, with_offsets), last = indenter_position(to, force.leftCols(3));
  if (!first || !last) return std::nullopt;
  Eigen::Matrix<double, 4, 2> motion;
  motion << *first, *last - *first, 1, -1;
  return motion;
}

std::optional<Piece> trace(const GapIncrement& increment, const Start& start, const std::vector<Trial>& trial) {
  const int count = int(trial.size());
  Eigen::MatrixXd right(2 * count, 4);
  right << right_side(increment, trial), Eigen::VectorXd::Zero(2 * count);
  for (int i = 0; i < count; ++i) {
    if (trial[i] == Trial::open) right(2 * i + 1, 3) = start.force_offset[i];
    if (slips(trial[i])) right(2 * i, 3) = friction_sign(trial[i]) * increment.mu * start.force_offset[i];
  }
  const auto response = increment.block.displacement(trial, increment.mu, right);
  if (!response) return std::nullopt;
  const Eigen::MatrixXd force = increment.block.surface_force(*response);
  const auto motion = indenter_motion(increment, start, force);
  if (!motion) return std::nullopt;

  const Eigen::MatrixXd u = increment.block.surface_part(*response) * *motion, f = force * *motion;
  const Eigen::VectorXd before = increment.block.surface_part(increment.previous.displacement);
  const auto line = [](const auto& lines, int k) { return Line{lines(k, 0), lines(k, 1)}; };
  const Line fading = line(*motion, 3);
  Piece piece;
  for (int i = 0; i < count; ++i) {
    const Line history{before[2 * i] - increment.previous.tangential, 0}, height{increment.height[i], 0};
    piece.gap.push_back(height - line(*motion, 1) - line(u, 2 * i + 1) + start.gap_offset[i] * fading);
    piece.slip.push_back(line(u, 2 * i) - line(*motion, 2) - history);
    piece.n.push_back(start.force_offset[i] * fading - line(f, 2 * i + 1));
    piece.t.push_back(line(f, 2 * i));
  }
  return piece;
}

// What must stay >= 0 for an element to go on as `from` rather than as `to`.
Line reserve(const Piece& piece, double mu, Eigen::Index i, Trial from, Trial to) {
  if (from == Trial::open) return piece.gap[i];
  if (from == Trial::stick) return mu * piece.n[i] - friction_sign(to) * piece.t[i];
  return to == Trial::open ? piece.n[i] : -friction_sign(from) * piece.slip[i];
}

// What an element may change to. One that closes slips against the slip it has had in this increment.
std::vector<Trial> alternatives(const Piece& piece, double mu, Eigen::Index i, Trial from, double lambda) {
  if (from == Trial::open) return {mu > 0 && piece.slip[i].at(lambda) > 0 ? Trial::slip_minus : Trial::slip_plus};
  if (from == Trial::stick) return {Trial::slip_plus, Trial::slip_minus};
  return mu > 0 ? std::vector{Trial::open, Trial::stick} : std::vector{Trial::open};
}

// The first condition to reach its limit from lambda on, in the given direction (1 or -1).
Change next_change(const Piece& piece, double mu, const std::vector<Trial>& trial, double lambda, double direction) {
  Change change{direction * std::numeric_limits<double>::infinity()};
  for (Eigen::Index i = 0; i < Eigen::Index(trial.size()); ++i) {
    for (Trial to : alternatives(piece, mu, i, trial[i], lambda)) {
      const Line line = reserve(piece, mu, i, trial[i], to);
      if (!(direction * line.slope < 0)) continue;
      double limit = -line.start / line.slope;
      if (direction * (limit - lambda) < 0) limit = lambda;  // passed by rounding
      if (direction * (limit - change.lambda) < 0) change = {limit, i, to};
    }
  }
  if (change.element >= 0 && trial[change.element] == Trial::open) {
    change.to = alternatives(piece, mu, change.element, Trial::open, change.lambda).front();
  }
  return change;
}

}  // namespace

std::optional<std::vector<Trial>> follow_path(const GapIncrement& increment, GapSearch& search, unsigned seed) {
  const Start start = start_of(increment, seed);
  std::vector<Trial> trial = start.trial;
  double lambda = 0, direction = 1;
  Change change;
  Trial left = Trial::open;  // what the changed element did before
  while (!search.exhausted()) {
    ++search.iterations;
    const auto piece = trace(increment, start, trial);
    if (!piece) return std::nullopt;
    // The condition that ended the old status is gone; the one that would bring it back starts from 0 and must grow.
    if (change.element >= 0) {
      direction = reserve(*piece, increment.mu, change.element, change.to, left).slope >= 0 ? 1 : -1;
    }
    change = next_change(*piece, increment.mu, trial, lambda, direction);
    if (change.lambda >= 1) return trial;
    if (change.lambda < 0 || change.element < 0) return std::nullopt;
    lambda = change.lambda;
    left = std::exchange(trial[change.element], change.to);
  }
  return std::nullopt;
}

}  // namespace tactel::fem
