// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "fem/layer/legendre_points.h"
#include "fem/numbers/angles.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/creep_history.h"
#include "fem/pad/layer_means.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_presses.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/slip_margin.h"

namespace tactel::fem {
namespace {

constexpr int most_force_trials = 60;

Eigen::Matrix2d own_to_pad(const PadIndenter& indenter, const PadCells& cells) {
  return Eigen::Rotation2Dd(radians(cells.frame(indenter))).toRotationMatrix();
}

Eigen::Vector2d position(const PadIndenter& indenter) { return {indenter.position[0], indenter.position[1]}; }

/// How often the layer's integrals are taken for the base stresses of cells, each from its own parts or from shared
/// ones. `soft_thickness`: that of the layer.
double stress_work(const PadScene& scene, const PadCells& cells, bool shared, double soft_thickness) {
  constexpr double points_of_part = 20;  // 16 to 36
  const auto along = [&](double h) {
    const double side = h / scene.sensor.thickness / soft_thickness;
    const int parts = PadLayer::parts(side);
    if (!shared) return cells.n * (parts > 1 ? 5.0 * parts : 1.0);
    return std::min((cells.n + 4.0) * parts, 2 * PadLayer::range / soft_thickness * parts / side);
  };
  const double tactels = static_cast<double>(scene.sensor.tactels[0]) * scene.sensor.tactels[1];
  return tactels * std::pow(TactelPoints::along(scene.sensor), 2) * points_of_part * along(cells.hx) * along(cells.hy);
}

/// Whether cells share parts: where they have some, and that takes less.
bool shares_parts(const PadScene& scene, const PadCells& cells, double soft_thickness = 1) {
  const double H = scene.sensor.thickness * soft_thickness;
  return PadLayer::parts(cells.hx / H) * PadLayer::parts(cells.hy / H) > 1 &&
         stress_work(scene, cells, true, soft_thickness) < stress_work(scene, cells, false, soft_thickness);
}

/// How much of the last change of the tractions to expect again: the part of the new change of the load along the last
/// one, over that; at most 2.
double growth(const Eigen::Vector4d& change, const Eigen::Vector4d& last) {
  return last.squaredNorm() > 0 ? std::clamp(change.dot(last) / last.squaredNorm(), 0.0, 2.0) : 0;
}

/// Parts of a drag along `way` after one along `last` (mm), by pad_increments.
int substeps(const Eigen::Vector3d& way, const Eigen::Vector3d& last, double limit, double to_limit) {
  constexpr double turn_weight = 3, most_limits = 2;
  const double along = last.squaredNorm() > 0 ? way.dot(last) / last.norm() : way.norm();
  const double turned = way.squaredNorm() - along * along, length = way.norm();
  if (!(length > 0 && limit > 0)) return 1;
  const double limits = length * (1 + turn_weight * turned / (length * length)) / limit;
  return std::max(1, static_cast<int>(std::ceil(to_limit * std::min(limits, most_limits) - 1e-9)));
}

/// Search for the depth that gives a force, by secants in the logarithms of depth and force inside a bracket.
class DepthSearch {
 public:
  /// The first depth to try.
  double start(double target, double depth, double P, double first_guess) {
    target_ = target, low_ = 0, high_ = infinity, last_ = {}, trials_ = 0;
    return P > 0 ? depth * std::clamp(std::pow(target / P, 1 / power_), 0.1, 10.0) : first_guess;
  }
  /// Judges a trial and gives the next depth. Returns false, and leaves it, within `tolerance` of the target.
  bool next(double P, double tolerance, double& depth) {
    if (std::abs(P - target_) <= tolerance * target_) return false;
    // Below a height map whose plain comes to bear late, P grows with a higher power than under any smooth shape.
    const double most_power = ++trials_ > usual_trials ? 64 : 4;
    if (last_[1] > 0 && P > 0 && depth != last_[0])
      power_ = std::clamp(std::log(P / last_[1]) / std::log(depth / last_[0]), 0.5, most_power);
    last_ = {depth, P};
    (P < target_ ? low_ : high_) = depth;
    // So narrow, it would hold no two forces that both miss: one of them was that of sweeps that had not settled.
    if (high_ - low_ <= 0.1 * tolerance * depth) low_ = 0, high_ = infinity;
    const double trial = depth * (P > 0 ? std::clamp(std::pow(target_ / P, 1 / power_), 0.1, 10.0) : 2);
    depth = trial > low_ && trial < high_ ? trial : std::isfinite(high_) ? (low_ + high_) / 2 : 2 * depth;
    return true;
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr int usual_trials = 20;
  int trials_ = 0;
  double target_ = 0, low_ = 0, high_ = infinity, power_ = 1.5;
  std::array<double, 2> last_{};  ///< depth and P of the last trial
};

PadOptions of_sweeps(PadOptions options, const PadScene& scene) {
  options.accept = options.accepted();
  if (by_force(scene)) options.tolerance /= 10;
  return options;
}

PadSides sides_of(const PadScene& scene, const PadOptions& options) {
  return sides_at(scene.sensor, position(scene.indenter), options.side_bricks, options.between_sweeps);
}

/// The table of a scene with free sides.
PadTable table_of(const PadLayer& layer, const PadCells& cells, const PadScene& scene, const PadSides& sides) {
  PadTable table(layer, sides, cells, own_to_pad(scene.indenter, cells), position(scene.indenter));
  const Eigen::VectorXd compliances = shared_compliances(cells, scene);
  for (int i = 0; i < cells.count(); ++i)
    if (compliances[i] > 0) table.soften(i, compliances[i]);
  return table;
}

/// What a scene's cells do to each other and to the base.
struct PadWorld {
  std::optional<PadInfluence> influence{};
  std::optional<PadTable> table{};  ///< with free sides, instead
  Eigen::MatrixXd stress;

  PadWorld(const PadLayer& layer, const PadOptions& options, const PadCells& cells, const PadScene& scene) {
    const PadSides sides = sides_of(scene, options);
    if (sides.free())
      table.emplace(table_of(layer, cells, scene, sides));
    else
      influence.emplace(layer, scene.sensor.thickness, cells.hx, cells.hy, cells.n);
    stress =
        sides.free() ? base_stress_of_cells(layer, scene, cells, sides) : base_stress_of_cells(layer, scene, cells);
  }
  PadContact contact(const PadOptions& options, const PadCells& cells, const PadScene& scene) const {
    const PadOptions sweeps = of_sweeps(options, scene);
    Eigen::MatrixXd heights = heights_on_pad(cells, scene);
    PadContact made = influence ? PadContact(*influence, cells, std::move(heights), scene.friction, sweeps)
                                : PadContact(*table, cells, std::move(heights), scene.friction, sweeps);
    made.set_friction(friction_on_cells(cells, scene));
    return made;
  }
};

/// A scene on its way along the load path, on one grid.
class PadWalk {
 public:
  PadWalk(const PadLayer& layer, const PadOptions& options, const PadCells& cells, const PadScene& scene)
      : turn_(own_to_pad(scene.indenter, cells)),
        options_(options),
        scene_(scene),
        cells_(cells),
        world_(layer, options, cells, scene),
        contact_(world_.contact(options, cells, scene)) {
    if (!scene.sensor.relaxation.empty()) creep_.emplace(scene.sensor.relaxation, cells.count());
    own_places_.resize(cells.count(), 2);
    for (int i = 0; i < cells.count(); ++i) own_places_.row(i) << cells.x(i / cells.n), cells.y(i % cells.n);
  }

  PadSolution walk();

 private:
  void move_to(const PadTarget& target);
  PadStep step_here(std::array<bool, 4>& outside) const;

  Eigen::Matrix2d turn_;                              ///< own frame to that of the pad
  Eigen::Vector4d change_ = Eigen::Vector4d::Zero();  ///< of the last increment: depth, motion; mm
  PadTarget target_;                                  ///< of the last increment
  const PadOptions& options_;
  const PadScene& scene_;
  PadCells cells_;
  PadWorld world_;
  PadContact contact_;
  std::optional<CreepHistory> creep_{};
  double softer_ = 1;  ///< the rubber of this increment, as it creeps
  Eigen::MatrixX2d own_places_;
  DepthSearch search_;
  bool converged_ = true;
  int sweeps_ = 0;
};

void PadWalk::move_to(const PadTarget& target) {
  const double per_E = softer_ / (scene_.sensor.young * cells_.area());
  const double first_guess = 0.05 * scene_.sensor.thickness;
  const double depth = !by_force(scene_) ? target.normal
                       : target.normal > 0
                           ? search_.start(target.normal * per_E, contact_.depth, contact_.pressing(), first_guess)
                           : 0;
  const Eigen::Vector2d own = turn_.transpose() * Eigen::Vector2d(target.x, target.y);
  const PadMotion to(own[0], own[1], target.twist);
  target_ = target;
  Eigen::Vector4d change(depth - contact_.depth, to[0] - contact_.motion[0], to[1] - contact_.motion[1],
                         cells_.half_size() * (to[2] - contact_.motion[2]));
  contact_.depth = depth;
  contact_.motion = to;
  const double ratio = growth(change, change_);
  change_ = change;
  if (change.isZero(0) && !creep_) return;
  contact_.extrapolate(ratio);
  const bool searches = by_force(scene_) && target.normal > 0;
  const int most_sweeps = converged_ ? options_.most_sweeps : std::min(options_.most_sweeps, damped_after);
  const auto solved = [&] { return contact_.solve(most_sweeps, sweeps_); };
  const auto misses = [&] { return search_.next(contact_.pressing(), options_.tolerance, contact_.depth); };
  bool settled = false;
  int trial = 0;
  do {
    settled = solved();
    while (settled && searches && misses()) settled = ++trial < most_force_trials && solved();
  } while (settled && contact_.refine());
  converged_ &= settled;
}

PadStep PadWalk::step_here(std::array<bool, 4>& outside) const {
  const double young = scene_.sensor.young / softer_, force = young * cells_.area();
  PadStep step;
  step.indentation = contact_.depth;
  step.twist = contact_.motion[2];
  step.x = target_.x, step.y = target_.y;
  const Eigen::VectorXd n = force * contact_.n();
  const Eigen::MatrixX2d t = force * contact_.t();
  const Eigen::RowVector2d own_Q = t.colwise().sum();
  step.P = n.sum();
  step.Q = turn_ * own_Q.transpose();
  step.M = own_places_.col(0).dot(t.col(1)) - own_places_.col(1).dot(t.col(0));
  step.mu = mean_friction(scene_, contact_.friction(), n);
  if (step.mu * step.P > 0) {
    const Eigen::VectorXd grip = contact_.friction().cwiseProduct(n);
    step.slip_index = std::min(1.0, slip_margin(own_places_, grip, {own_Q[0], own_Q[1], step.M}));
    step.force_ratio = step.Q.norm() / (step.mu * step.P);
  }
  int touch = 0, stick = 0;
  for (Eigen::Index i = 0; i < n.size(); ++i) {
    const bool sticks = contact_.sticks(i);
    touch += n[i] > 0;
    stick += sticks;
    step.status.push_back(!(n[i] > 0) ? GapStatus::open : sticks ? GapStatus::stick : GapStatus::slip);
  }
  step.stick_fraction = touch > 0 ? static_cast<double>(stick) / touch : 0;
  step.slip_distance = contact_.slip_distance();
  step.slid = contact_.slid(), step.slip_path = contact_.slip_path();
  step.area = touch * cells_.area();
  std::array<int, 4> ends{cells_.n, -1, cells_.n, -1};
  const Eigen::Vector2d half = turn_.cwiseAbs() * Eigen::Vector2d(cells_.hx / 2, cells_.hy / 2);
  for (Eigen::Index i = 0; i < n.size(); ++i) {
    if (!(n[i] > 0)) continue;
    const Eigen::Vector2d at = turn_ * own_places_.row(i).transpose(), low = at - half, high = at + half;
    step.reach.cover({{low[0], high[0]}, {low[1], high[1]}});
    const int ix = static_cast<int>(i) / cells_.n, iy = static_cast<int>(i) % cells_.n;
    ends = {std::min(ends[0], ix), std::max(ends[1], ix), std::min(ends[2], iy), std::max(ends[3], iy)};
  }
  step.across = touch > 0 ? 1 + std::min(ends[1] - ends[0], ends[3] - ends[2]) : 0;
  step.normal_force = n;
  step.tangential_force = t * turn_.transpose();
  if (creep_) {
    step.straining = scene_.sensor.young * cells_.area() * creep_->straining(contact_);
    step.straining.rightCols<2>() *= turn_.transpose();
  }
  Eigen::VectorXd tractions(3 * n.size());
  tractions << contact_.n(), contact_.t().col(0), contact_.t().col(1);
  step.stress = young * (world_.stress * tractions).reshaped(world_.stress.rows() / 3, 3);
  step.residual = contact_.residual(outside);
  const bool finite =
      std::isfinite(step.P + step.Q.sum() + step.M) && step.stress.allFinite();  // a residual may be 0 beside NaN
  step.converged = converged_ && finite && step.residual.largest() <= options_.accepted();
  step.iterations = sweeps_;
  return step;
}

PadSolution PadWalk::walk() {
  PadSolution solution;
  solution.cells = cells_;
  solution.places = (own_places_ * turn_.transpose()).rowwise() + position(scene_.indenter).transpose();
  for (const PadIncrement& increment : pad_increments(scene_, options_, cells_)) {
    if (creep_) softer_ = creep_->begin(contact_, increment.dt);
    move_to(increment.target);
    contact_.add_slide();
    if (increment.asked) {
      solution.steps.push_back(step_here(solution.outside));
      converged_ = solution.steps.back().converged;
      sweeps_ = 0;
    }
    if (!converged_ && !options_.whole_path) break;
    contact_.remember();
    if (creep_) creep_->end(contact_);
  }
  solution.steps.resize(pad_targets(scene_.load).size());
  return solution;
}

}  // namespace

Eigen::MatrixXd heights_on_pad(const PadCells& cells, const PadScene& scene) {
  Eigen::MatrixXd heights = cell_heights(cells, scene.indenter);
  if (std::isinf(rubber_of(scene.sensor).x.right)) return heights;  // everywhere
  for (int i = -1; i <= cells.n; ++i)
    for (int j = -1; j <= cells.n; ++j)
      if (!on_pad(scene.sensor, scene.indenter, cells.frame(scene.indenter), cells.x(i), cells.y(j)))
        heights(i + 1, j + 1) = std::numeric_limits<double>::infinity();
  return heights;
}

Eigen::VectorXd friction_on_cells(const PadCells& cells, const PadScene& scene) {
  Eigen::MatrixX2d places(cells.count(), 2);
  for (int i = 0; i < cells.count(); ++i) places.row(i) << cells.x(i / cells.ny()), cells.y(i % cells.ny());
  places *= own_to_pad(scene.indenter, cells).transpose();
  return friction_at(scene, places.rowwise() + position(scene.indenter).transpose());
}

double mean_friction(const PadScene& scene, const Eigen::VectorXd& mu, const Eigen::VectorXd& n) {
  return scene.friction_map && n.sum() > 0 ? mu.dot(n) / n.sum() : scene.friction;
}

Eigen::VectorXd shared_compliances(const PadCells& cells, const PadScene& scene) {
  Eigen::VectorXd compliances = Eigen::VectorXd::Zero(cells.count());
  if (!cells.shared) return compliances;
  const Eigen::MatrixXd shares = covered_shares(cells, scene.indenter);
  constexpr double all = 1 - 1e-9;
  const double nu = scene.sensor.poisson,
               softer = 1 + soft_object(scene.sensor, scene.indenter).normal() / (1 - nu * nu);
  for (int i = 0; i < cells.count(); ++i)
    if (const double share = shares(i / cells.n + 1, i % cells.n + 1); share > 0 && share < all)
      compliances[i] = softer * share_compliance(share, cells, nu);
  return compliances;
}

namespace {

/// How much more layers upon layers give way to waves as long as cells of half a size than their uppermost alone.
struct Softer {
  Softer(const PadSensor& sensor, double half_size) {
    if (sensor.layers.empty()) return;
    const double a = sensor.thickness / half_size;
    const LayerTransforms one = layer_transforms(sensor.poisson, a), all = stack_transforms(sensor.layers, a).plane;
    normal = all.yy / one.yy, tangential = all.xx / one.xx;
  }
  double normal = 1, tangential = 1;
};

}  // namespace

double sliding_limit(const PadScene& scene, double normal, const PadCells& cells) {
  const Softer softer(scene.sensor, cells.half_size());
  const double nu = scene.sensor.poisson,
               mu = scene.friction_map ? friction_on_cells(cells, scene).mean() : scene.friction;
  const SoftObject object = soft_object(scene.sensor, scene.indenter);
  if (!by_force(scene)) {
    const double more = (softer.tangential + object.tangential() / ((1 + nu) * (2 - nu))) /
                        (softer.normal + object.normal() / (1 - nu * nu));
    return mu * normal * (2 - nu) / (2 * (1 - nu)) * more;
  }
  const double G = scene.sensor.young / (2 * (1 + nu)), area = cells.count() * cells.area();
  const double a = std::sqrt(area / std::numbers::pi), of_object = object.tangential() / (4 * a * scene.sensor.young);
  return 1.5 * mu * normal * of_object +
         1.5 * mu * normal * softer.tangential / (G * (8 * a / (2 - nu) + area / scene.sensor.thickness));
}

std::vector<PadIncrement> pad_increments(const PadScene& scene, const PadOptions& options, const PadCells& cells) {
  const PadLoad& load = scene.load;
  const int parts = (options.increments() + load.indentation_steps - 1) / load.indentation_steps;
  const std::vector<PadTarget> targets = pad_targets(load);
  const std::size_t pressing = pressing_targets(load);
  std::vector<PadIncrement> increments;
  PadTarget from;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  double last_time = 0;
  for (std::size_t k = 0; k < targets.size(); ++k) {
    const PadTarget& to = targets[k];
    const Eigen::Vector3d way(to.x - from.x, to.y - from.y, cells.half_size() * (to.twist - from.twist));
    const double limit = sliding_limit(scene, std::max(from.normal, to.normal), cells);
    const int presses = to.normal == from.normal ? 1 : parts;
    const int drags = std::max(options.drag_increments, substeps(way, last, limit, options.to_limit()));
    const int count = options.parts * (k < pressing ? presses : drags);
    const double time = load.times.empty() ? 0 : load.times[k], dt = (time - last_time) / count;
    last_time = time;
    const auto between = [](double a, double b, double part) { return a + (b - a) * part; };
    for (int i = 1; i < count; ++i) {
      const double part = static_cast<double>(i) / count;
      increments.push_back({{between(from.normal, to.normal, part), between(from.x, to.x, part),
                             between(from.y, to.y, part), between(from.twist, to.twist, part)},
                            false,
                            dt});
    }
    increments.push_back({to, true, dt});
    from = to;
    if (!way.isZero(0)) last = way;
  }
  return increments;
}

Eigen::MatrixX2d tactel_places(const PadSensor& sensor) {
  const auto [columns, rows] = sensor.tactels;
  Eigen::MatrixX2d places(columns * rows, 2);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      places.row(row * columns + column) << (column - (columns - 1) / 2.0) * sensor.pitch[0],
          (row - (rows - 1) / 2.0) * sensor.pitch[1];
  return places;
}

int TactelPoints::along(const PadSensor& sensor) {
  return sensor.tactel_size > 0 ? 3 + static_cast<int>(std::ceil(2 * sensor.tactel_size / sensor.thickness)) : 1;
}

TactelPoints::TactelPoints(const PadSensor& sensor) {
  const Eigen::MatrixX2d middles = tactel_places(sensor);
  const double half = sensor.tactel_size / 2;
  const std::vector<LegendrePoint> points =
      half > 0 ? legendre_points(along(sensor)) : std::vector<LegendrePoint>{{0, 2}};
  for (const auto& p : points)
    for (const auto& q : points) weights.push_back(p.weight * q.weight / 4);
  places.resize(middles.rows() * static_cast<Eigen::Index>(weights.size()), 2);
  Eigen::Index k = 0;
  for (Eigen::Index tactel = 0; tactel < middles.rows(); ++tactel)
    for (const auto& p : points)
      for (const auto& q : points) places.row(k++) = middles.row(tactel) + half * Eigen::RowVector2d(p.x, q.x);
}

double base_stress_work(const PadScene& scene, const PadCells& cells) {
  return stress_work(scene, cells, shares_parts(scene, cells), 1);
}

namespace {

/// Puts together the rows of all tactels. `add(place, weight, sums)` adds the base stress of each cell at a place,
/// which is in its frame, from the axis.
template <class Add>
Eigen::MatrixXd stress_rows(const PadScene& scene, const PadCells& cells, Add add) {
  const TactelPoints points(scene.sensor);
  const Eigen::Index parts = std::ssize(points.weights), count = points.places.rows() / parts,
                     cell_count = cells.count();
  const Eigen::Matrix2d turn = own_to_pad(scene.indenter, cells);
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.bottomRightCorner<2, 2>() = turn;
  Eigen::MatrixXd stress(3 * count, 3 * cell_count);
  std::vector<PadBaseStress> sums(cell_count);
  for (Eigen::Index k = 0; k < count; ++k) {
    std::ranges::fill(sums, PadBaseStress(PadBaseStress::Zero()));
    for (Eigen::Index p = 0; p < parts; ++p) {
      const Eigen::Vector2d place = points.places.row(k * parts + p).transpose() - position(scene.indenter);
      add(Eigen::Vector2d(turn.transpose() * place), points.weights[p], sums);
    }
    for (Eigen::Index i = 0; i < cell_count; ++i) {
      const PadBaseStress at = turned * sums[i];
      for (int row = 0; row < 3; ++row) {
        stress(row * count + k, i) = -at(row, 2);  // pressure is the negative of f_z
        stress(row * count + k, cell_count + i) = at(row, 0);
        stress(row * count + k, 2 * cell_count + i) = at(row, 1);
      }
    }
  }
  return stress;
}

}  // namespace

Eigen::MatrixXd base_stress_of_cells(const PadLayer& layer, const PadScene& scene, const PadCells& cells) {
  const double H = scene.sensor.thickness;
  const bool shared = shares_parts(scene, cells, layer.soft_thickness());
  const int ny = cells.ny(), n = std::max(cells.n, ny);
  return stress_rows(scene, cells, [&](const Eigen::Vector2d& own, double weight, std::vector<PadBaseStress>& sums) {
    std::vector<PadBaseStress> all;
    if (shared) all = layer.base_stresses(H, cells.hx, cells.hy, n, own[0] - cells.x(0), own[1] - cells.y(0));
    for (int i = 0; i < cells.count(); ++i)
      sums[i] += weight * (shared ? all[i / ny * n + i % ny]
                                  : layer.base_stress(H, cells.hx, cells.hy, own[0] - cells.x(i / ny),
                                                      own[1] - cells.y(i % ny)));
  });
}

Eigen::MatrixXd base_stress_of_cells(const PadLayer& layer, const PadScene& scene, const PadCells& cells,
                                     const PadSides& sides) {
  const Eigen::Matrix2d turn = own_to_pad(scene.indenter, cells);
  Eigen::Matrix3d to_pad = Eigen::Matrix3d::Identity(), to_own = Eigen::Matrix3d::Identity();
  to_pad.topLeftCorner<2, 2>() = turn;                  // of tractions x, y, z
  to_own.bottomRightCorner<2, 2>() = turn.transpose();  // of stresses sigma_z, tau_x, tau_y
  const auto on_pad_at = [&](double x, double y) -> Eigen::Vector2d {
    return sides.in_block(turn * Eigen::Vector2d(x, y) + position(scene.indenter));
  };
  std::vector<SideGrid::Shares> shares;
  for (int i = 0; i < cells.count(); ++i) {
    const Eigen::Vector2d at = on_pad_at(cells.x(i / cells.ny()), cells.y(i % cells.ny()));
    shares.push_back(sides.base->grid().shares(at[0], at[1]));
  }
  const double H = sides.thickness, scale = cells.area() / (H * H);
  return stress_rows(scene, cells, [&](const Eigen::Vector2d& own, double weight, std::vector<PadBaseStress>& sums) {
    const Eigen::Vector2d at = on_pad_at(own[0], own[1]);
    const Eigen::MatrixXd side = sides.base->stress(at[0], at[1]);
    for (int i = 0; i < cells.count(); ++i) {
      PadBaseStress more = PadBaseStress::Zero();
      for (int k = 0; k < shares[i].count; ++k) more += shares[i].share[k] * side.middleCols<3>(3 * shares[i].node[k]);
      const double x = own[0] - cells.x(i / cells.ny()), y = own[1] - cells.y(i % cells.ny());
      sums[i] += weight * (uniform_base_stress(layer, H, cells.hx, cells.hy, x, y) + scale * to_own * more * to_pad);
    }
  });
}

PadCells grown(const PadCells& cells, const std::array<bool, 4>& sides, const PadScene& scene, bool ladder) {
  PadBox box = cells.box();
  box.x.left -= sides[0] * 1.5 * cells.hx;
  box.x.right += sides[1] * 1.5 * cells.hx;
  box.y.left -= sides[2] * 1.5 * cells.hy;
  box.y.right += sides[3] * 1.5 * cells.hy;
  if (has_free_sides(scene.sensor))
    return pad_cells(box, scene.indenter, cells.n,
                     rubber_along(scene.sensor, scene.indenter, cells.frame(scene.indenter)), cells.turn);
  return pad_cells(box, scene.indenter, cells.n, scene.sensor.thickness, ladder);
}

PadSolver::PadSolver(const PadLayer& layer, const PadOptions& options) : layer_(layer), options_(options) {}

PadSolution PadSolver::solve_on(const PadCells& cells, const PadScene& scene) const {
  require_times(scene);
  if (layer_.object() != soft_object(scene.sensor, scene.indenter))
    throw std::logic_error("PadSolver: a layer beside another object");
  return PadWalk(layer_, options_, cells, scene).walk();
}

PadSolution PadSolver::solve(const PadScene& scene) const {
  scene.validate();
  PadSolution solution = solve_on_grown(scene);
  for (const std::size_t k : coarse_presses(scene, solution)) {
    PadSolution alone = solve_on_grown(pressed_alone(scene, k));
    see_markers(scene, alone, options_.between_sweeps);
    take_alone(solution, k, alone);
  }
  return solution;
}

PadSolution PadSolver::solve_on_grown(const PadScene& scene) const {
  auto [indenter, cells, depth] = lay_cells(scene, layer_, options_.cells, options_.ladder, sides_of(scene, options_));
  PadScene seen = scene;
  seen.indenter = std::move(indenter);
  for (int growths = 0;; ++growths) {
    PadSolution solution = solve_on(cells, seen);
    const auto& out = solution.outside;
    if (std::none_of(out.begin(), out.end(), [](bool side) { return side; }) || growths == options_.most_growths)
      return solution;
    cells = grown(cells, out, seen, options_.ladder);
  }
}

}  // namespace tactel::fem
