// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_lanes.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "fem/numbers/angles.h"
#include "host/contact/contact_batch.h"
#include "host/contact/strata.h"

namespace tactel::host {
namespace {

constexpr int pad_friction_strata = 4;

/// How straight the indenter's way is: chord over length, in tenths. Where it turns, guesses from the increment before
/// are worse and sweeps more.
int straightness(const fem::PadScene& scene, double lever) {
  Eigen::Vector3d at(0, 0, 0);
  double length = 0;
  for (const fem::PadTarget& target : fem::pad_targets(scene.load)) {
    const Eigen::Vector3d to(target.x, target.y, lever * target.twist);
    length += (to - at).norm();
    at = to;
  }
  return length > 0 ? static_cast<int>(9.999 * at.norm() / length) : 9;
}

}  // namespace

double PadOnCells::frame() const { return fem::radians(cells.frame(scene.indenter)); }

PadLanes::PadLanes(const std::vector<PadOnCells>& scenes, int vectors, std::size_t width, bool two_fit)
    : vectors(vectors), width(width) {
  if (!scenes.empty() && scenes.front().sides.kernel) {
    in_lane.resize(scenes.size());
    std::iota(in_lane.begin(), in_lane.end(), std::size_t{0});
    this->width = 1, own_groups = scenes.size();
    return;
  }
  std::vector<double> friction;
  friction.reserve(scenes.size());
  for (const PadOnCells& of : scenes) friction.push_back(of.scene.friction);
  const std::vector<int> stratum = strata(friction, pad_friction_strata);
  using Cost = std::tuple<std::size_t, std::size_t, int, int, double, std::size_t>;
  std::map<PadOnCells::Table, std::vector<Cost>> by_table;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadScene& scene = scenes[i].scene;
    const double half_size = scenes[i].cells.half_size();
    by_table[scenes[i].table()].emplace_back(scenes[i].path.size(), scene.indenter.shape.index(), stratum[i],
                                             straightness(scene, half_size), half_size, i);
  }
  if (vectors == 0) {
    // Two vectors share each number of the table. That pays where they are full.
    std::size_t full = 0;
    for (const auto& [table, members] : by_table) full += members.size() / (2 * width) * 2 * width;
    this->vectors = two_fit && 2 * full >= scenes.size() ? 2 : 1;
  }
  const std::size_t size = static_cast<std::size_t>(this->vectors) * width;
  const auto place = [&](const Cost& member) { in_lane.push_back(std::get<5>(member)); };
  const auto fill_up = [&](std::size_t to) {
    in_lane.resize((in_lane.size() + to - 1) / to * to, no_scene);
    return in_lane.size();
  };
  std::vector<Cost> alone;
  for (auto& [table, members] : by_table) {
    std::ranges::sort(members);
    const std::size_t rest = members.size() % size, sharing = members.size() - (5 * rest < 3 * size ? rest : 0);
    for (std::size_t k = 0; k < sharing; ++k) {
      if (k % size == 0) first_of_group.push_back(std::get<5>(members[k]));
      place(members[k]);
    }
    fill_up(size);
    alone.insert(alone.end(), members.begin() + static_cast<std::ptrdiff_t>(sharing), members.end());
  }
  groups = first_of_group.size();
  std::ranges::sort(alone);
  for (const Cost& member : alone) place(member);
  own_groups = (fill_up(width) - groups * size) / width;
}

}  // namespace tactel::host
