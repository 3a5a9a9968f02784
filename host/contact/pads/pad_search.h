// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "fem/pad/pad_search.h"
#include "host/device/executor.h"

namespace tactel::host {

/// The rectangles that indenters touch on pads: launcher of kernels/pad_search.cl. Scenes may have sensors of their
/// own. Programs for one precision. Cheap to copy.
template <class Real>
class PadSearch {
 public:
  /// `any_poisson`: of scenes with a Poisson's ratio each.
  explicit PadSearch(Executor& executor, bool any_poisson = false);

  /// Returns what fem::find_pad_contact finds for each scene, with `depths` ([scenes] mm) fem::find_pad_contact_at.
  /// A contact has the same bits in every batch and order. Where its outermost cells bear next to nothing, it may end a
  /// cell of the search beside the twin's.
  std::vector<fem::PadSearch> find(std::span<const fem::PadScene* const> scenes,
                                   std::span<const double> depths = {}) const;
  std::vector<fem::PadSearch> find(std::span<const fem::PadScene> scenes, std::span<const double> depths = {}) const {
    std::vector<const fem::PadScene*> all;
    for (const fem::PadScene& scene : scenes) all.push_back(&scene);
    return find(all, depths);
  }

 private:
  struct State;
  std::shared_ptr<State> state_;
};

extern template class PadSearch<float>;
extern template class PadSearch<double>;

}  // namespace tactel::host
