// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/profile_csv.h"

#include <fmt/format.h>

#include "host/support/errors.h"
#include "host/support/number_lines.h"

namespace tactel::host {
namespace {

constexpr std::uintmax_t largest_table = std::uintmax_t{16} << 20;
constexpr double highest = 1e6;  // mm
constexpr const char *two_columns =
                         "at least 2 lines of x and y in mm, such as the three lines `x,y` `-1.0,0.05` `0.0,0.0`",
                     *a_grid = "2 to 1000 lines of 2 to 1000 heights in mm, one line for each y";

}  // namespace

void read_profile_csv(const std::filesystem::path& path, fem::Profile& profile) {
  NumberLines lines(path.string(),
                    {.count = 2, .meaning = "x and y in mm", .names = {"x", "y"}, .largest = highest, .quotes = false});
  profile.x.clear();
  profile.y.clear();
  read_number_file(path, largest_table, "indenter.file", lines, [&](std::span<const double> point) {
    if (!profile.x.empty() && point[0] <= profile.x.back())
      lines.refuse("x", fmt::format("{}", point[0]), "greater than the x on the line before");
    profile.x.push_back(point[0]);
    profile.y.push_back(point[1]);
  });
  if (profile.x.size() < 2) throw ConfigError(path.string(), "points", std::to_string(profile.x.size()), two_columns);
}

void read_heights_csv(const std::filesystem::path& path, fem::HeightMap& map) {
  NumberLines lines(path.string(),
                    {.meaning = "heights in mm, as many as on the first line", .largest = highest, .quotes = false});
  std::vector<double> heights;
  std::size_t columns = 0, rows = 0;
  read_number_file(path, largest_table, "indenter.file", lines, [&](std::span<const double> row) {
    columns = row.size();
    if (columns < 2 || columns > longest_height_map) lines.refuse("heights", std::to_string(columns), a_grid);
    if (++rows > longest_height_map) lines.refuse("lines", std::to_string(rows), a_grid);
    heights.insert(heights.end(), row.begin(), row.end());
  });
  if (rows < 2) throw ConfigError(path.string(), "lines", std::to_string(rows), a_grid);
  map.heights = Eigen::Map<const Eigen::MatrixXd>(heights.data(), static_cast<Eigen::Index>(columns),
                                                  static_cast<Eigen::Index>(rows));
  map.heights.array() -= map.heights.minCoeff();
}

void read_friction_csv(const std::filesystem::path& path, FrictionMap& map) {
  NumberLines lines(path.string(),
                    {.meaning = "coefficients of friction, as many as on the first line", .quotes = false});
  read_number_file(path, largest_table, "contact.friction_map", lines,
                   [&](std::span<const double> row) { map.rows.emplace_back(row.begin(), row.end()); });
}

void read_places_csv(const std::filesystem::path& path, std::vector<std::array<double, 2>>& places) {
  NumberLines lines(path.string(),
                    {.count = 2, .meaning = "x and y in mm", .names = {"x", "y"}, .largest = highest, .quotes = false});
  read_number_file(path, largest_table, "markers.places", lines, [&](std::span<const double> place) {
    places.push_back({place[0], place[1]});
  });
  if (places.empty()) throw ConfigError(path.string(), "places", "0", "a line of x and y in mm for each marker");
}

}  // namespace tactel::host
