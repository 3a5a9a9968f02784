// SPDX-License-Identifier: Apache-2.0
#include "host/training/frame_floor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactel::host {
namespace {

/// Contacts of two drawn numbers on two transducers, steps 0 and 1. The first number moves the frame of step 1 by 3 and
/// 4 MPa and S by 2, that of step 0 by 1 and 0 MPa; the second moves nothing, and its step 1 is missing.
struct WorkedRows {
  std::vector<float> frames{1, 1, 1, 1, /* first */ 1 + 1 / 64.f, 1, 1 + 3 / 64.f, 1 + 4 / 64.f, /* second */ 1,
                            1, 9, 9};
  std::vector<float> slip_index{0, 0.5f, 0, 0.5f + 2 / 64.f, 0, 0};
  std::vector<std::uint64_t> contact{6, 6, 7, 7, 8, 8};
  std::vector<std::uint32_t> step{0, 1, 0, 1, 0, 1};
  std::vector<std::uint8_t> status{0, 1, 0, 0, 0, 2};
  double error(std::vector<std::int64_t> reading, double gain) const {
    return linear_errors({.inputs = 2,
                          .changes = 3,
                          .shift = 1.0 / 64,
                          .frames = frames,
                          .slip_index = slip_index,
                          .contact = contact,
                          .step = step,
                          .status = status},
                         {std::move(reading), {0.5}, gain})
        .front();
  }
};

double of_precision(double precision) { return std::sqrt(2 / M_PI) * 2 / std::sqrt(precision); }

TEST(FrameFloor, LinearErrorsAreWorkedByHand) {
  const WorkedRows rows;
  // Noise 0.5 MPa: (9 + 16) / 0.25 + 12. Numbers of fp32: 1 + 3/64 is exact.
  EXPECT_NEAR(rows.error({1}, 0), of_precision(112), 1e-12);
  // Gains of deviation 1 and a stress of 1 MPa: each transducer has the variance 0.25 + 1.
  EXPECT_NEAR(rows.error({1}, 1), of_precision(25 / 1.25 + 12), 1e-12);
  // A frame behind it adds 1 / 0.25; zeros from before the contact add nothing.
  EXPECT_NEAR(rows.error({1, 0}, 0), of_precision(116), 1e-12);
  EXPECT_NEAR(rows.error({1, -1}, 0), of_precision(112), 1e-12);
  // One gain for both frames: transducer 1 has J = (3, 1), covariance 0.25 I + ones, whose inverse is 4 I - 16 / 9
  // ones: 40 - 16 / 9 16. Transducer 2 has J = (4, 0): 64 - 16 / 9 16.
  EXPECT_NEAR(rows.error({1, 0}, 1), of_precision(104 - 2 * 16 * 16 / 9.0 + 12), 1e-12);
}

}  // namespace
}  // namespace tactel::host
