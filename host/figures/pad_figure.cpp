// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/numbers/angles.h"
#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"

namespace tactel::host {
namespace {

using fem::GapStatus;
using fem::PadScene;
using fem::PadSolution;
using fem::PadStep;
using Range = std::pair<double, double>;

/// A closed line through points.
Series closed_line(const Eigen::MatrixX2d& points, Mark mark, Ink ink) {
  Series line{.x = list(points.col(0)), .y = list(points.col(1)), .mark = mark, .ink = ink};
  if (!line.x.empty()) line.x.push_back(line.x.front()), line.y.push_back(line.y.front());
  return line;
}

/// Arrows from places [n][2] along vectors [n][2], `scale` axis units each, as one broken line.
Series arrows(const Eigen::MatrixX2d& places, const Eigen::MatrixX2d& vectors, double scale) {
  constexpr double head = 0.3, spread = 0.45;  // of the length; rad
  Series out{.mark = Mark::line, .ink = Ink::black};
  const auto to = [&](const Eigen::RowVector2d& point) { out.x.push_back(point[0]), out.y.push_back(point[1]); };
  for (Eigen::Index k = 0; k < places.rows(); ++k) {
    const Eigen::RowVector2d from = places.row(k), way = scale * vectors.row(k), tip = from + way;
    if (!(way.norm() > 0)) continue;
    const auto barb = [&](double turn) -> Eigen::RowVector2d {
      return tip - head * way * Eigen::Rotation2Dd(turn).toRotationMatrix().transpose();
    };
    to(from), to(tip), to(barb(spread)), to(tip), to(barb(-spread)), to({NAN, NAN});
  }
  return out;
}

/// Ranges of a panel's axes that hold points, a millimetre as long along both.
void fit(const Figure& figure, Panel& panel, const std::vector<Eigen::MatrixX2d>& parts) {
  constexpr double room = 1.1;
  Eigen::RowVector2d low(INFINITY, INFINITY), high = -low;
  for (const Eigen::MatrixX2d& points : parts)
    for (const auto& point : points.rowwise()) low = low.cwiseMin(point), high = high.cwiseMax(point);
  const auto [width, height] = axes_size(figure, panel);
  const Eigen::RowVector2d pixels(width, height), middle = (low + high) / 2;
  const double pixel = room * (high - low).cwiseQuotient(pixels).maxCoeff();
  const auto range = [&](int axis) {
    return Range(middle[axis] - pixel * pixels[axis] / 2, middle[axis] + pixel * pixels[axis] / 2);
  };
  panel.x_range = range(0), panel.y_range = range(1);
}

Mosaic mosaic(std::string unit, Palette palette, double most) {
  return {.unit = std::move(unit), .palette = palette, .most = most > 0 ? most : 1};
}

void add(Mosaic& mosaic, const Eigen::MatrixX2d& corners, double value) {
  for (const auto& corner : corners.rowwise()) mosaic.x.push_back(corner[0]), mosaic.y.push_back(corner[1]);
  mosaic.values.push_back(value);
}

/// Corners of a rectangle about a place.
Eigen::MatrixX2d rectangle(const Eigen::RowVector2d& middle, const Eigen::RowVector2d& sides) {
  const Eigen::Matrix<double, 4, 2> signs{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  return (signs * (sides / 2).asDiagonal()).rowwise() + middle;
}

class PadFigure {
 public:
  PadFigure(const PadScene& scene, const PadSolution& solution, std::size_t shown)
      : scene_(scene), solution_(solution), cells_(solution.cells), shown_(shown), step_(solution.steps[shown]) {}

  Figure figure() const {
    const std::string what = scene_.title.empty() ? fem::shape_name(scene_.indenter.shape) : scene_.title;
    Figure figure{.title = fmt::format("{}: depth {:.4g} mm, drag ({:.4g}, {:.4g}) mm, twist {:.4g}°", plain(what),
                                       step_.indentation, step_.x, step_.y, fem::degrees(step_.twist)),
                  .columns = 2,
                  .width = 1000,
                  .panel_height = 440};
    figure.panels = {surface_panel(figure), tactel_panel(figure), cut_panel()};
    if (solution_.steps.size() > 1) figure.panels.push_back(grip_panel());
    return figure;
  }

 private:
  double side() const { return std::sqrt(cells_.area()); }
  Eigen::MatrixX2d outline() const {
    return on_pad(scene_.indenter, section_outline(fem::over_skin(scene_.indenter, scene_.sensor), step_.indentation));
  }
  Eigen::MatrixX2d corners() const { return cell_corners(scene_.indenter, cells_); }

  Series marked_cells(GapStatus status) const {
    return marked(step_.status, solution_.places.col(0), solution_.places.col(1), status);
  }

  Panel surface_panel(const Figure& figure) const {
    Panel panel{.title = "On the surface: pressure, shear (arrows)", .x_label = "x (mm)", .y_label = "y (mm)"};
    const Eigen::MatrixX2d all = corners();
    const Eigen::MatrixXi of_cell = corners_of_cells(cells_.n);
    panel.mosaic = mosaic("pressure (MPa)", Palette::sequential, step_.normal_force.maxCoeff() / cells_.area());
    for (Eigen::Index k = 0; k < of_cell.rows(); ++k)
      if (step_.status[static_cast<std::size_t>(k)] != GapStatus::open)
        add(*panel.mosaic, all(of_cell.row(k), Eigen::all), step_.normal_force[k] / cells_.area());
    const double most = step_.tangential_force.rowwise().norm().maxCoeff();
    panel.series = {arrows(solution_.places, step_.tangential_force, most > 0 ? 1.4 * side() / most : 0),
                    closed_line(outline(), Mark::dashed, Ink::black), marked_cells(GapStatus::stick),
                    marked_cells(GapStatus::slip)};
    fit(figure, panel, {all});
    return panel;
  }

  Panel tactel_panel(const Figure& figure) const {
    const fem::PadSensor& sensor = scene_.sensor;
    const auto [columns, rows] = sensor.tactels;
    const Eigen::RowVector2d pitch(sensor.pitch[0], sensor.pitch[1]), array(columns * pitch[0], rows * pitch[1]);
    Panel panel{.title = sensor.axes == 3 ? "At the tactels: σ_z, shear (arrows)" : "At the tactels: σ_z",
                .x_label = "x (mm)",
                .y_label = "y (mm)"};
    const Eigen::MatrixX2d places = fem::tactel_places(sensor);
    panel.mosaic = mosaic("σ_z (MPa)", Palette::diverging, step_.stress.col(0).cwiseAbs().maxCoeff());
    for (Eigen::Index k = 0; k < places.rows(); ++k)
      add(*panel.mosaic, rectangle(places.row(k), 0.8 * pitch), step_.stress(k, 0));
    const double most = step_.stress.rightCols<2>().rowwise().norm().maxCoeff();
    if (sensor.axes == 3)
      panel.series.push_back(arrows(places, step_.stress.rightCols<2>(), most > 0 ? 0.7 * pitch.minCoeff() / most : 0));
    panel.series.push_back(closed_line(outline(), Mark::dashed, Ink::black));
    const Eigen::RowVector2d pad(sensor.length.value_or(array[0]), sensor.width.value_or(array[1]));
    const Eigen::MatrixX2d rim = rectangle({0, 0}, pad);
    if (sensor.length && sensor.width) panel.series.push_back(closed_line(rim, Mark::line, Ink::grey));
    fit(figure, panel, {rectangle({0, 0}, pad.cwiseMin(1.3 * array)), corners()});  // a wide pad is cut off
    return panel;
  }

  /// The row of cells along the indenter's own x that holds its axis.
  Panel cut_panel() const {
    const int n = cells_.n,
              row = std::clamp(static_cast<int>(std::floor(n / 2.0 - cells_.y_middle / cells_.hy + 1e-6)), 0, n - 1);
    Series pressure{.label = "pressure p", .ink = Ink::blue},
        shear{.label = "shear |t|", .mark = Mark::long_dashes, .ink = Ink::orange},
        limit{.label = "µp", .mark = Mark::dashed, .ink = Ink::grey};
    Series stick{.label = "stick", .mark = Mark::circles, .ink = Ink::green},
        slip{.label = "slip", .mark = Mark::triangles, .ink = Ink::red};
    const Eigen::VectorXd mu = fem::friction_at(scene_, solution_.places);
    for (int i = 0; i < n; ++i) {
      const int k = i * n + row;
      const double p = step_.normal_force[k] / cells_.area(), t = step_.tangential_force.row(k).norm() / cells_.area();
      for (const double x : {cells_.x(i) - cells_.hx / 2, cells_.x(i) + cells_.hx / 2}) {
        pressure.x.push_back(x), pressure.y.push_back(p);
        shear.x.push_back(x), shear.y.push_back(t);
        limit.x.push_back(x), limit.y.push_back(mu[k] * p);
      }
      const GapStatus status = step_.status[static_cast<std::size_t>(k)];
      if (status == GapStatus::open) continue;
      Series& marks = status == GapStatus::stick ? stick : slip;
      marks.x.push_back(cells_.x(i)), marks.y.push_back(t);
    }
    return {.title = fmt::format("Along the indenter's own x, at own y = {:.2g} mm", cells_.y(row)),
            .x_label = "own x (mm)",
            .y_label = "traction (MPa)",
            .series = {pressure, limit, shear, stick, slip},
            .zero_line = true};
  }

  Panel grip_panel() const {
    const auto S = [](const PadStep& step) { return step.slip_index.value_or(NAN); };
    const auto ratio = [](const PadStep& step) { return step.force_ratio.value_or(NAN); };
    const auto stick = [](const PadStep& step) { return sticking_share(step); };
    return path_panel({along_path(solution_.steps, "part that sticks", Ink::green, Mark::long_dashes, stick),
                       along_path(solution_.steps, "|Q| / µP", Ink::orange, Mark::dash_triangles, ratio),
                       along_path(solution_.steps, "S", Ink::black, Mark::line_dots, S)},
                      shown_);
  }

  const PadScene& scene_;
  const PadSolution& solution_;
  const fem::PadCells& cells_;
  std::size_t shown_;
  const PadStep& step_;
};

}  // namespace

Figure contact_figure(const PadScene& scene, const PadSolution& solution, std::size_t step) {
  return PadFigure(scene, solution, step).figure();
}

}  // namespace tactel::host
