// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/pad/pad_solver.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// A solved contact over its load steps as the script of pages draws it (host/figures/page/), and what the picture
/// shows, in words.
struct ContactView {
  nlohmann::ordered_json data;
  std::string caption;
};

inline std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

/// Returns a number with so many significant digits; null where it is none.
inline nlohmann::ordered_json rounded(double value, int digits = 5) {
  if (!std::isfinite(value)) return {};
  return std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr);
}
nlohmann::ordered_json rounded(const auto& values, int digits = 5) {
  auto out = nlohmann::ordered_json::array();
  for (const double value : values) out.push_back(rounded(value, digits));
  return out;
}

/// Returns which of `count` load steps a page holds: 24 at most, fewer where they are large, always with `shown` and
/// the last. `bytes_each`: of a step on the page, about.
std::vector<std::size_t> shown_steps(std::size_t count, std::size_t shown, std::size_t bytes_each);

/// Says that steps were left out; empty where none was.
std::string steps_left_out(std::size_t shown, std::size_t count);

/// Returns the view of a contact: indenter, displaced rubber, status, tractions, stress in the rubber and at the
/// tactels, and forces along the path. The stress in the rubber is that of the block of finite elements under the
/// contact's own forces: of a mesh on that mesh, of a patch on a mesh with its tractions. It has 81 x 13 points with
/// 8 bits. A long path is shown at no more than 24 of its steps, always with `shown` and the last.
ContactView contact_view(const fem::Scene& scene, const fem::ContactSolution& solution, std::size_t shown);

/// Returns the force of each element of a patch [elements] N/mm at the nodes of a surface [columns] N/mm, that is the
/// load of a constant traction on each element, consistent with linear interpolation between the nodes.
Eigen::VectorXd nodal_loads(const Eigen::VectorXd& force, const Eigen::VectorXd& place, const Eigen::VectorXd& width,
                            const Eigen::VectorXd& node_x);

/// Returns bytes as base64 text (RFC 4648).
std::string base64(const std::vector<std::uint8_t>& bytes);

/// Returns the view of a contact on a pad: tractions and status of the cells, stress at the tactels, the indenter's
/// outline, and forces along the path (host/figures/page/pad.js). Tractions are those of the indenter on the rubber. Of
/// a long path only some steps are shown (shown_steps).
ContactView contact_view(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t shown);

/// Returns the outline of the part of an indenter that lies below the undeformed surface at a depth, [points][2] mm in
/// the indenter's own frame, counter-clockwise, as seen from its middle. Empty where the depth is not above 0.
Eigen::MatrixX2d section_outline(const fem::PadIndenter& indenter, double depth);

/// Returns places [n][2] of the indenter's own frame on the pad, mm.
Eigen::MatrixX2d on_pad(const fem::PadIndenter& indenter, const Eigen::MatrixX2d& own);

/// Returns the corners of the cells on the pad, [n + 1][n + 1] mm, in their order.
Eigen::MatrixX2d cell_corners(const fem::PadIndenter& indenter, const fem::PadCells& cells);

/// Returns the corners of each cell among those, counter-clockwise, [cells][4].
Eigen::MatrixXi corners_of_cells(int n);

}  // namespace tactel::host
