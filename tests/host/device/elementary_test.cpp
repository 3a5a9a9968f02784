// SPDX-License-Identifier: Apache-2.0

// kernels/shared/elementary.h against the C library, in both precisions, and the same bits at every number of lanes.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "host/device/buffer.h"
#include "host/device/executor.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::elementary_test {

// u in (0, 1); v = 160 u - 80; w = 2 u
const char* const text =
    "#include \"shared/activation.h\"\n#include \"shared/group.h\"\n#include \"shared/elementary.h\"\n"
    "kernel void elementary(uint first_group, global const vreal *u, global vreal *out, uint groups) {\n"
    "  TAKE_GROUP(group);\n"
    "  const vreal x = u[group];\n"
    "  vreal sine;\n"
    "  out[group] = natural_log(x);\n"
    "  out[groups + group] = natural_exp(x * 160 - 80);\n"
    "  out[2 * groups + group] = cos_pi(x * 2, &sine);\n"
    "  out[3 * groups + group] = sine;\n"
    "  out[4 * groups + group] = activation(x * 160 - 80);\n"
    "}\n";

constexpr std::size_t count = 4096;  // a multiple of every number of lanes

/// Multiples of 2^-20, so that 160 u - 80 and 2 u are exact; the ends, the middle and the quarters among them.
template <class Real>
std::vector<Real> units() {
  std::mt19937 random(5);
  std::vector<Real> u(count);
  for (Real& x : u) x = (random() % ((1u << 20) - 1) + 1) * Real(0x1p-20);
  const Real special[] = {Real(0x1p-20), 1 - Real(0x1p-20), Real(0.5), Real(0.25), Real(0.75), Real(0.125)};
  std::copy(std::begin(special), std::end(special), u.begin());
  return u;
}

template <class Real>
std::vector<Real> values(const Device& device, const std::vector<Real>& u) {
  const Precision precision = sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64;
  const Program program = Program::from_text(device, "elementary_test.cl", text, lanes_of(device, precision));
  Buffer<Real> in(device, u.size()), out(device, 5 * u.size());
  in.write(u);
  const auto groups = static_cast<std::uint32_t>(u.size() / static_cast<std::size_t>(device.lanes(precision)));
  Executor executor(device);
  const auto bind = [&](KernelArguments& kernel) { kernel.set(1, in), kernel.set(2, out), kernel.set(3, groups); };
  executor.run_here(executor.prepare(program, "elementary", bind), groups);
  std::vector<Real> answers(5 * u.size());
  out.read(answers);
  return answers;
}

// The logarithm rounds a quotient, a product and a sum; the exponential a sum, a product and one over it; sine and
// cosine pi r and one more: half an eps each.
template <class Real>
void expect_near_the_library() {
  const auto u = units<Real>();
  const auto got = values<Real>(device(), u);
  const double eps = std::numeric_limits<Real>::epsilon();
  for (std::size_t i = 0; i < count; ++i) {
    const double x = u[i], v = 160 * x - 80;
    const long double turn = 2 * std::numbers::pi_v<long double> * x;
    EXPECT_NEAR(got[i], std::log(x), 2 * eps * std::max(std::abs(std::log(x)), eps)) << x;
    EXPECT_NEAR(got[count + i] / std::exp(v), 1, 4 * eps) << v;
    EXPECT_NEAR(got[2 * count + i], static_cast<double>(std::cos(turn)), eps) << x;
    EXPECT_NEAR(got[3 * count + i], static_cast<double>(std::sin(turn)), eps) << x;
    EXPECT_NEAR(got[4 * count + i], 0.5 * std::tanh(0.5 * v), sizeof(Real) == 4 ? 1.7e-7 : eps) << v;
  }
}

TEST(ElementaryFunctions, AreThoseOfTheLibrary) {
  expect_near_the_library<float>();
  expect_near_the_library<double>();
}

template <class Real>
void expect_same_bits() {
  const auto u = units<Real>();
  const auto once = values<Real>(device(), u);
  for (const int lanes : {1, 2, 16}) EXPECT_EQ(values<Real>(device().with_lanes(lanes), u), once) << lanes;
  EXPECT_EQ(values<Real>(device().for_one_contact(), u), once);
}

TEST(ElementaryFunctions, HaveTheSameBitsAtEveryNumberOfLanes) {
  expect_same_bits<float>();
  expect_same_bits<double>();
}

}  // namespace tactel::host::elementary_test
