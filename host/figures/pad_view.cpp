// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/pad/pad_markers.h"
#include "fem/pad/side_kernel.h"
#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;
using fem::PadScene;
using fem::PadSolution;
using fem::PadStep;

constexpr double degrees = 180 / std::numbers::pi;

/// [x, y] of each point, so that the script draws them in order.
Json points(const Eigen::MatrixX2d& places) {
  Json out = Json::array();
  for (const auto& place : places.rowwise()) out.push_back(rounded(place, 4));
  return out;
}

/// Bytes of a step on the page, about: three numbers a cell that touches, and three a tactel.
std::size_t bytes_of_pad_step(const PadSolution& solution) {
  std::size_t touching = 0, cells = static_cast<std::size_t>(solution.cells.count());
  for (const PadStep& step : solution.steps)
    touching =
        std::max(touching, cells - static_cast<std::size_t>(std::ranges::count(step.status, fem::GapStatus::open)));
  return 600 + 7 * cells + 26 * touching + 30 * static_cast<std::size_t>(solution.steps.front().stress.rows());
}

/// Builds the view step by step.
class PadBuilder {
 public:
  PadBuilder(const PadScene& scene, const PadSolution& solution, std::size_t shown)
      : scene_(scene),
        solution_(solution),
        steps_(shown_steps(solution.steps.size(), shown, bytes_of_pad_step(solution))),
        shown_(shown) {}

  ContactView view() { return {data(), caption()}; }

 private:
  const PadStep& step(std::size_t k) const { return solution_.steps[steps_[k]]; }
  double area() const { return solution_.cells.area(); }

  Json step_json(std::size_t k) {
    const PadStep& s = step(k);
    std::string status;
    for (const fem::GapStatus each : s.status) status += "otl"[static_cast<int>(each)];
    Json out = {{"number", steps_[k] + 1},
                {"indentation", rounded(s.indentation)},
                {"drag", rounded(std::array{s.x, s.y})},
                {"twist", rounded(s.twist * degrees)},
                {"P", rounded(s.P, 6)},
                {"Q", rounded(s.Q, 6)},
                {"M", rounded(s.M, 6)},
                {"S", rounded(s.slip_index.value_or(NAN), 6)},
                {"ratio", rounded(s.force_ratio.value_or(NAN), 6)},
                {"outline", outline_at(s.indentation)},
                {"status", status},
                {"p", rounded(s.normal_force / area())},
                {"tx", rounded(s.tangential_force.col(0) / area())},
                {"ty", rounded(s.tangential_force.col(1) / area())},
                {"sigma", rounded(s.stress.col(0))},
                {"tau_x", rounded(s.stress.col(1))},
                {"tau_y", rounded(s.stress.col(2))}};
    if (scene_.markers)
      for (const int axis : {0, 1, 2}) out["u"].push_back(rounded(s.markers.col(axis)));
    return out;
  }

  /// Index of the outline at a depth: steps of one depth share it.
  std::size_t outline_at(double depth) {
    const auto at = std::ranges::find(depths_, depth);
    const auto index = static_cast<std::size_t>(at - depths_.begin());
    if (at == depths_.end()) {
      depths_.push_back(depth);
      outlines_.push_back(
          points(on_pad(scene_.indenter, section_outline(fem::over_skin(scene_.indenter, scene_.sensor), depth))));
    }
    return index;
  }

  Json path_json() const {
    std::vector<double> number, P, Qx, Qy, M, S, ratio, stick;
    for (const PadStep& s : solution_.steps) {
      number.push_back(static_cast<double>(number.size() + 1));
      P.push_back(s.P), Qx.push_back(s.Q[0]), Qy.push_back(s.Q[1]), M.push_back(s.M);
      S.push_back(s.slip_index.value_or(NAN)), ratio.push_back(s.force_ratio.value_or(NAN));
      stick.push_back(sticking_share(s));
    }
    return {{"number", rounded(number)}, {"P", rounded(P)}, {"Qx", rounded(Qx)},       {"Qy", rounded(Qy)},
            {"M", rounded(M)},           {"S", rounded(S)}, {"ratio", rounded(ratio)}, {"stick", rounded(stick)}};
  }

  /// Largest sizes over all steps that are shown, so that colours and arrows mean the same at each.
  Json most() const {
    double p = 0, t = 0, sigma = 0, tau = 0;
    for (std::size_t k = 0; k < steps_.size(); ++k) {
      p = std::max(p, step(k).normal_force.maxCoeff() / area());
      t = std::max(t, step(k).tangential_force.rowwise().norm().maxCoeff() / area());
      sigma = std::max(sigma, step(k).stress.col(0).cwiseAbs().maxCoeff());
      tau = std::max(tau, step(k).stress.rightCols<2>().rowwise().norm().maxCoeff());
    }
    Json out = {{"p", rounded(p)}, {"t", rounded(t)}, {"sigma", rounded(sigma)}, {"tau", rounded(tau)}};
    if (scene_.markers) {
      double along = 0, down = 0;
      for (std::size_t k = 0; k < steps_.size(); ++k) {
        along = std::max(along, step(k).markers.leftCols<2>().rowwise().norm().maxCoeff());
        down = std::max(down, step(k).markers.col(2).cwiseAbs().maxCoeff());
      }
      out["u"] = rounded(along), out["w"] = rounded(down);
    }
    return out;
  }

  Json sensor_json() const {
    const fem::PadSensor& sensor = scene_.sensor;
    const auto side = [](const std::optional<double>& given) { return given ? Json(*given) : Json(); };
    return {{"tactels", sensor.tactels},     {"pitch", sensor.pitch},
            {"size", sensor.tactel_size},    {"axes", sensor.axes},
            {"length", side(sensor.length)}, {"width", side(sensor.width)},
            {"thickness", sensor.thickness}, {"sides", fem::name(fem::side_rules(sensor).sides)}};
  }

  Json cells_json() const {
    const fem::PadCells& cells = solution_.cells;
    return {{"n", cells.n},
            {"sides", rounded(std::array{cells.hx, cells.hy}, 9)},
            {"middle", rounded(std::array{cells.x_middle, cells.y_middle}, 9)}};
  }

  Json data() {
    Json steps = Json::array();
    for (std::size_t k = 0; k < steps_.size(); ++k) steps.push_back(step_json(k));
    Json out = {
        {"mu", scene_.friction_map ? rounded(fem::friction_at(scene_, solution_.places)) : rounded(scene_.friction)},
        {"position", scene_.indenter.position},
        {"yaw", scene_.indenter.yaw},
        {"sensor", sensor_json()},
        {"cells", cells_json()},
        {"outlines", outlines_},
        {"most", most()},
        {"path", path_json()},
        {"shown", std::ranges::find(steps_, shown_) - steps_.begin()},
        {"steps", std::move(steps)}};
    if (scene_.markers) out["markers"] = fem::marker_places(*scene_.markers);
    return out;
  }

  std::string caption() const {
    return fmt::format(
        "A {} pressed on {} mm of rubber ({}E = {} MPa, ν = {}, µ = {}), seen from above: x to the right, y up. First "
        "map: "
        "the {} x {} cells of the surface with the tractions of the indenter on the rubber; the green line surrounds "
        "the cells that stick. Second map: the pad with its tactels, σ_z at the base as colour (σ_z < 0 is "
        "compression){}, and the outline of the contact. Dashed: the part of the indenter below the undeformed "
        "surface. x′ and y′ are its own axes; the cuts run along them. Colours and arrows have one scale for all "
        "steps. M is about the indenter's axis. {}{}",
        fem::shape_name(scene_.indenter.shape), scene_.sensor.thickness,
        scene_.sensor.layers.empty() ? "" : fmt::format("{} layers, at the surface ", scene_.sensor.layers.size()),
        scene_.sensor.young, scene_.sensor.poisson, fem::friction_text(scene_), solution_.cells.n, solution_.cells.n,
        scene_.sensor.axes == 3 ? ", arrows are the shear stress τ" : "",
        scene_.markers ? fmt::format("Third map: displacements of the markers, {} mm below it. ", scene_.markers->depth)
                       : "",
        steps_left_out(steps_.size(), solution_.steps.size()));
  }

  const PadScene& scene_;
  const PadSolution& solution_;
  std::vector<std::size_t> steps_;
  std::size_t shown_;
  std::vector<double> depths_;
  Json outlines_ = Json::array();
};

/// A point of the section at a depth, on its own frame's 41 x 41 points of a box: the middle of those in the section,
/// or the lowest where the middle is not in it.
Eigen::RowVector2d point_of_section(const fem::PadIndenter& indenter, const fem::PadBox& box, double depth) {
  constexpr int points = 40;
  Eigen::RowVector2d lowest(0, 0), sum(0, 0);
  double least = INFINITY, inside = 0;
  for (int i = 0; i <= points; ++i)
    for (int j = 0; j <= points; ++j) {
      const Eigen::RowVector2d at(box.x.left + (box.x.right - box.x.left) * i / points,
                                  box.y.left + (box.y.right - box.y.left) * j / points);
      const double height = fem::pad_height(indenter, at[0], at[1]);
      if (height < least) least = height, lowest = at;
      if (height <= depth) sum += at, ++inside;
    }
  const Eigen::RowVector2d middle = sum / std::max(inside, 1.0);
  return fem::pad_height(indenter, middle[0], middle[1]) <= depth ? middle : lowest;
}

}  // namespace

ContactView contact_view(const PadScene& scene, const PadSolution& solution, std::size_t shown) {
  return PadBuilder(scene, solution, shown).view();
}

Eigen::MatrixX2d section_outline(const fem::PadIndenter& indenter, double depth) {
  constexpr int directions = 72;
  const fem::PadBox box = fem::rigid_section(indenter, depth);
  const Eigen::RowVector2d from = point_of_section(indenter, box, depth);
  if (!(depth > 0) || !(fem::pad_height(indenter, from[0], from[1]) <= depth)) return Eigen::MatrixX2d(0, 2);
  std::vector<double> angles;
  angles.reserve(directions + 4);
  for (int k = 0; k < directions; ++k)
    angles.push_back(2 * std::numbers::pi * (k + 0.5) / directions - std::numbers::pi);
  for (const double x : {box.x.left, box.x.right})  // corners stay sharp
    for (const double y : {box.y.left, box.y.right}) angles.push_back(std::atan2(y - from[1], x - from[0]));
  std::ranges::sort(angles);
  const double reach = std::hypot(box.x.right - box.x.left, box.y.right - box.y.left);
  Eigen::MatrixX2d outline(static_cast<Eigen::Index>(angles.size()), 2);
  for (Eigen::Index k = 0; k < outline.rows(); ++k) {
    const double angle = angles[static_cast<std::size_t>(k)];
    const Eigen::RowVector2d way(std::cos(angle), std::sin(angle));
    double inside = 0, outside = reach;
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = 0.5 * (inside + outside);
      const Eigen::RowVector2d at = from + middle * way;
      (fem::pad_height(indenter, at[0], at[1]) <= depth ? inside : outside) = middle;
    }
    outline.row(k) = from + inside * way;
  }
  return outline;
}

Eigen::MatrixX2d on_pad(const fem::PadIndenter& indenter, const Eigen::MatrixX2d& own) {
  const Eigen::Rotation2Dd turn(indenter.yaw / degrees);
  const Eigen::RowVector2d axis(indenter.position[0], indenter.position[1]);
  return (own * turn.toRotationMatrix().transpose()).rowwise() + axis;
}

Eigen::MatrixX2d cell_corners(const fem::PadIndenter& indenter, const fem::PadCells& cells) {
  Eigen::MatrixX2d own((cells.n + 1) * (cells.n + 1), 2);
  const fem::PadBox box = cells.box();
  for (int i = 0; i <= cells.n; ++i)
    for (int j = 0; j <= cells.n; ++j)
      own.row(i * (cells.n + 1) + j) << box.x.left + i * cells.hx, box.y.left + j * cells.hy;
  return on_pad(indenter, own);
}

Eigen::MatrixXi corners_of_cells(int n) {
  Eigen::MatrixXi corners(n * n, 4);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int first = i * (n + 1) + j;
      corners.row(i * n + j) << first, first + n + 1, first + n + 2, first + 1;
    }
  return corners;
}

}  // namespace tactel::host
