// SPDX-License-Identifier: Apache-2.0
#include "host/contact/lines/sensor_tables.h"

#include <fmt/format.h>

#include <mutex>
#include <optional>

#include "host/support/side_by_side.h"

namespace tactel::host {

void make_tables(Executor& executor, std::size_t count, const std::function<void(std::size_t)>& make) {
  std::mutex mutex;
  std::size_t made = 0;
  std::optional<BusyMessage> busy;
  const auto say = [&] { busy.emplace(executor.device(), fmt::format("tables of sensors, {} of {}", made, count)); };
  say();
  side_by_side(count, executor.threads(), [&](std::size_t k) {
    make(k);
    const std::lock_guard lock(mutex);
    if (++made < count) say();
  });
}

fem::SensorFamily sensor_family(Executor& executor, const fem::SensorRange& range, bool sides) {
  const std::vector<double> poissons = fem::SensorFamily::node_poissons(range);
  std::vector<std::optional<fem::FamilyNode>> made(poissons.size());
  make_tables(executor, poissons.size(),
              [&](std::size_t k) { made[k] = fem::SensorFamily::node(range, poissons[k], sides); });
  std::vector<fem::FamilyNode> nodes;
  nodes.reserve(made.size());
  for (auto& node : made) nodes.push_back(std::move(*node));
  return {range, nodes};
}

}  // namespace tactel::host
