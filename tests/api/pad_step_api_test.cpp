// SPDX-License-Identifier: Apache-2.0

// PadStepper of tactel::simulate beside the launcher that it hides: the same bits.
#include <gtest/gtest.h>
#include <tactel/pad_step.h>

#include <array>

#include "host/contact/pads/pad_step.h"
#include "kernels/shared/pad_step_layout.h"
#include "tests/thrown_message.h"

namespace pad_step_api_test {

using namespace tactel;

const Pad pad{.tactels = {3, 2}, .pitch = {1, 1}, .thickness = 2};
const std::array friction{0.3, 0.6};

PadStepper ball(const StepOptions& options = {.cells = 10, .cell = 0.4}) {
  PadStepper steps(pad, 2, friction, options);
  steps.set_shapes(std::array{PadIndenter{.shape = Sphere{.radius = 6}, .position = {0.1, 0.2}}});
  return steps;
}

TEST(PadStepApi, HasTheBitsOfItsLauncher) {
  PadStepper steps = ball();
  host::Executor executor{host::Device()};
  host::PadStepper<float> launcher(executor, pad, 2, friction, steps.options());
  const fem::PadIndenter indenter{.shape = Sphere{.radius = 6}};
  for (std::size_t c = 0; c < 2; ++c)
    launcher.set_surface(c, fem::pad_surface(launcher.cells(), indenter, {0.1, 0.2}, 0));
  launcher.set_axes(std::array{0.1, 0.2, 0.1, 0.2});
  const std::array<double, 8> presses{0.1, 0, 0, 0, 0.2, 0, 0, 0}, wrench{0.8, 0.1, 0, 0.02, 1.2, 0.2, 0.1, 0};
  steps.move(presses), launcher.move(presses);
  const StepAnswer& answer = steps.press(wrench);
  launcher.press(wrench);
  for (std::size_t c = 0; c < 2; ++c) {
    const auto row = [&](int k) { return launcher.results()[c * STEP_RESULT_ROWS + static_cast<std::size_t>(k)]; };
    for (int k = 0; k < 4; ++k) EXPECT_EQ(answer.force[4 * c + static_cast<std::size_t>(k)], row(STEP_RESULT_P + k));
    EXPECT_EQ(answer.slip_index[c], row(STEP_RESULT_S));
    EXPECT_EQ(answer.pose[4 * c], row(STEP_RESULT_DEPTH));
    EXPECT_EQ(answer.flags[c], static_cast<std::uint32_t>(row(STEP_RESULT_FLAGS)));
  }
  for (std::size_t k = 0; k < 2 * 3 * steps.tactels(); ++k) EXPECT_EQ(steps.frames()[k], launcher.frames()[k]);
}

TEST(PadStepApi, GoesOnFromAState) {
  PadStepper steps = ball(), other = ball();
  steps.press(std::array{0.8, 0.0, 0.0, 0.0, 1.2, 0.0, 0.0, 0.0});
  other.set_state(steps.state());
  const std::array<double, 8> wrench{0.8, 0.1, 0, 0.02, 1.2, 0.2, 0.1, 0};
  EXPECT_EQ(other.press(wrench).slip_index, steps.press(wrench).slip_index);
  PadStepper moved = std::move(other);
  moved.reset(std::array<std::uint8_t, 2>{1, 0});
  EXPECT_EQ(moved.press(std::array{0.0, 0.0, 0.0, 0.0, 1.2, 0.2, 0.1, 0.0}).flags[0], std::uint32_t(step_open));
}

TEST(PadStepApi, ServesBothPrecisions) {
  PadStepper single = ball(), twice = ball({.cells = 10, .cell = 0.4, .precision = "fp64"});
  const std::array<double, 8> to{0.2, 0.05, 0, 1, 0.25, 0.02, 0.01, 0};
  const StepAnswer a = single.move(to), b = twice.move(to);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(a.force[k], b.force[k], 2e-3 * b.force[0]);  // tolerance of sweeps
  EXPECT_EQ(twice.frames().size(), 2 * 3 * twice.tactels());
}

TEST(PadStepApi, SaysWhatIsWrong) {
  const auto message = [](const auto& call) { return thrown_message<InputError>(call); };
  Pad block{.tactels = {4, 4}, .pitch = {4.7, 4.7}};
  block.length = 19, block.width = 18, block.thickness = 4.5;
  EXPECT_EQ(message([&] { PadStepper(block, 1, std::array{0.5}, {.cells = 10, .cell = 1.9}); }),
            "cell: 1.9; must be 1.8 mm at most, as 10 cells lie within the pad");
  PadStepper steps = ball();
  EXPECT_EQ(message([&] { steps.press(std::array{1.0}); }), "wrench: 1 numbers; must be 8 numbers");
  EXPECT_EQ(message([&] { steps.move_by(std::array<double, 6>{}); }), "gaps: none; must be given before a motion");
}

}  // namespace pad_step_api_test
