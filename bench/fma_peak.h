// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "host/device/buffer.h"
#include "host/device/executor.h"

namespace tactel::bench {

/// Of runs; a neighbour on the machine disturbs single ones.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

inline host::Program peak_program(const host::Device& device, host::Precision precision) {
  return host::Program(device, "fma_peak.cl",
                       {{"LANES", std::to_string(device.lanes(precision))}, {"REAL", host::real_type(precision)}});
}

/// kernels/fma_peak.cl on some groups, with its output.
template <class Real>
struct Peak {
  static constexpr host::Precision precision = sizeof(Real) == 4 ? host::Precision::fp32 : host::Precision::fp64;
  host::Executor executor;
  host::Buffer<Real> out;
  host::Launch launch;
  std::size_t groups;
  double flops;  ///< of a run

  Peak(const host::Device& device, int threads, std::size_t groups, int rounds)
      : executor(device, {.threads = threads}),
        out(device, groups * device.lanes(precision)),
        launch(executor.prepare(peak_program(device, precision), "fma_peak",
                                [&](host::KernelArguments& kernel) {
                                  kernel.set(1, out);
                                  kernel.set(2, rounds);
                                })),
        groups(groups),
        flops(24.0 * rounds * static_cast<double>(out.size())) {}

  /// The roof: some 9 ms a run, in groups of 0.13 ms. In groups of 16 us two threads spend a tenth in launches.
  Peak(const host::Device& device, int threads)
      : Peak(device, threads, 64 * static_cast<std::size_t>(threads), 1 << 16) {}

  bool right() {
    executor.run(launch, groups);
    const auto map = out.map(host::MapFor::reading);
    return std::ranges::all_of(map.view(), [](Real sum) { return sum == Real(12); });
  }
  double run() { return executor.run(launch, groups).seconds; }  ///< seconds
};

}  // namespace tactel::bench
