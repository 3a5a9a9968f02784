// SPDX-License-Identifier: Apache-2.0

// tactel::infer in a host program that does as it likes: its own rounding and traps, NULL, names with a NUL byte.
#include <fenv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tactel.h>
#include <tactel/infer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "host/networks/onnx_file.h"
#include "nn/infer/network_file.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/network_cases.h"
#include "tests/host/support/run_tactel.h"

namespace infer_host_test {

using namespace tactel;
using tactel::tests::bounded_model;
using tactel::tests::bumps;
using ::testing::HasSubstr;

/// Every answer that the library gives to the frames: loaded anew, one by one, together, and as a history.
std::vector<Answer> all_answers(const std::string& file, const nn::RowMatrix<float>& frames) {
  const SlipEstimator estimator = SlipEstimator::parse(std::as_bytes(std::span(file)));
  const auto rows = static_cast<std::size_t>(frames.size()) / estimator.inputs();
  std::vector<Answer> answers(rows);
  EXPECT_EQ(estimator.estimate({frames.data(), rows * estimator.inputs()}, answers), rows);
  for (std::size_t i = 0; i < rows; ++i)
    answers.push_back(estimator.estimate({frames.data() + i * estimator.inputs(), estimator.inputs()}));
  SlipHistory history(estimator);
  for (std::size_t i = 0; i < static_cast<std::size_t>(frames.size()) / history.inputs(); ++i)
    answers.push_back(history.estimate({frames.data() + i * history.inputs(), history.inputs()}));
  return answers;
}

struct Case {
  std::string file;
  nn::RowMatrix<float> frames;
  std::vector<Answer> expected;  ///< in the arithmetic that a program starts with
};

std::vector<Case> cases() {
  nn::Model plain{
      nn::initial_weights(nn::Topology::parse("42-42-21-1"), 7), {nn::ScalingKind::set, 1.37f}, 7, 0, "", 0, {}};
  nn::Model history{
      nn::initial_weights(nn::Topology::parse("24-9-1"), 7), {nn::ScalingKind::frame, 1.0f, 3}, 7, 0, "", 0, {}};
  history.history = {.frames = 3, .stride = 2, .change = 0.07};
  std::vector<Case> all;
  for (const nn::Model& model : {plain, history, bounded_model("42-42-21-3", nn::ScalingKind::frame, true)}) {
    Case one{infer::network_bytes(model), bumps(200, model.weights.topology.inputs(), 9).frames, {}};
    one.frames.topRows(9) *= 1e-38f;  // some denormal
    one.expected = all_answers(one.file, one.frames);
    all.push_back(std::move(one));
  }
  return all;
}

void expect_same_bits(const std::vector<Answer>& answers, const std::vector<Answer>& expected) {
  ASSERT_EQ(answers.size(), expected.size());
  for (std::size_t i = 0; i < answers.size(); ++i)
    EXPECT_EQ((std::bit_cast<std::array<unsigned, 8>>(answers[i])),
              (std::bit_cast<std::array<unsigned, 8>>(expected[i])))
        << i;
}

// A grip of 0.1 MPa that holds, and one whose object has turned and tips.
TEST(InferHost, HasANetworkOfUskinPads) {
  const SlipEstimator network = SlipEstimator::load("uskin-4x4");
  EXPECT_EQ(network.inputs(), 96u);
  EXPECT_EQ(network.tactels(), 16u);
  EXPECT_EQ(network.metadata("target"), "slip_path");
  EXPECT_EQ(network.metadata("target_definition"),
            "D / (1 + D), D: rms slips of its cells since rest, summed, over its elastic limit");
  Alarm alarm(network, {.touch = 0.01});
  std::vector<float> frame(48, -0.1f);
  std::fill(frame.begin() + 16, frame.end(), 0.03f);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(alarm.next(frame).on);
  EXPECT_LT(alarm.next(frame).answer.slip_index, network.alarm_at());
  for (std::size_t i = 0; i < 16; ++i) {
    const std::size_t column = i % 4, row = i / 4;
    const float x = 0.03f * (static_cast<float>(column) - 1.5f), y = 0.03f * (static_cast<float>(row) - 1.5f);
    frame[i] += y, frame[16 + i] -= y, frame[32 + i] += x;
  }
  EXPECT_TRUE(alarm.next(frame).on);
  const std::unique_ptr<tactel_estimator, void (*)(tactel_estimator*)> in_c(tactel_load("uskin-4x4"), tactel_free);
  ASSERT_NE(in_c, nullptr) << tactel_error();
  EXPECT_EQ(tactel_inputs(in_c.get()), 96u);
}

// Without options an alarm without a network is one of left; with the default ones there is nothing to judge by.
TEST(InferHost, AnAlarmOfLeftInC) {
  const std::unique_ptr<tactel_alarm, void (*)(tactel_alarm*)> alarm(tactel_alarm_create_moved(4, 1, nullptr),
                                                                     tactel_alarm_free);
  ASSERT_NE(alarm, nullptr) << tactel_error();
  AlarmOptions options;
  options.signal = AlarmSignal::left;
  Alarm same(4, 1, options);
  tactel_alarm_rate(alarm.get(), 30), same.rate(30);
  tactel_alarm_answer said{};
  for (int i = 0; i < 40; ++i) {  // pressure moves to one side by a tenth at 30
    const float turned = (i < 30 ? 0 : 0.1f) + 1e-4f * static_cast<float>(i % 3);
    const std::array<float, 4> frame{-0.1f + turned, -0.1f - turned, -0.1f + turned, -0.1f - turned};
    said = tactel_alarm_next(alarm.get(), frame.data(), frame.size());
    const AlarmAnswer expected = same.next(frame);
    EXPECT_EQ(said.on, i > 30) << i << ": the median of three";
    EXPECT_EQ(said.rest, i >= 9) << i;
    EXPECT_EQ(said.why, i < 9 ? TACTEL_NO_REST : TACTEL_CAN_TELL) << i;
    EXPECT_EQ(std::bit_cast<unsigned>(said.left), std::bit_cast<unsigned>(expected.left)) << i;
    EXPECT_EQ(std::bit_cast<unsigned>(said.calm), std::bit_cast<unsigned>(expected.calm)) << i;
  }
  EXPECT_EQ(tactel_alarm_slides(alarm.get()), 0) << "normal stresses alone have no friction";
  EXPECT_STREQ(tactel_cannot_tell_name(TACTEL_FROZEN), "frozen");
  const tactel_alarm_options defaults = tactel_alarm_defaults();
  EXPECT_EQ(tactel_alarm_create_moved(4, 3, &defaults), nullptr);
  EXPECT_THAT(tactel_error(), HasSubstr("signal: slip"));
}

TEST(InferHost, GivesItsBitsInAnyRoundingMode) {
  for (const Case& one : cases())
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      ASSERT_EQ(fesetround(mode), 0);
      const std::vector<Answer> answers = all_answers(one.file, one.frames);
      EXPECT_EQ(fegetround(), mode);  // as the host left it
      fesetround(FE_TONEAREST);
      expect_same_bits(answers, one.expected);
    }
}

#if defined(__x86_64__)
// A host that takes denormal numbers for zero, and frames with such numbers.
TEST(InferHost, GivesItsBitsToAHostWithoutDenormals) {
  for (const Case& one : cases()) {
    __builtin_ia32_ldmxcsr(0x9fc0);
    const std::vector<Answer> answers = all_answers(one.file, one.frames);
    EXPECT_EQ(__builtin_ia32_stmxcsr() & 0x8040u, 0x8040u);
    __builtin_ia32_ldmxcsr(0x1f80);
    expect_same_bits(answers, one.expected);
  }
}
#endif

// A host that traps what is not exact is not stopped by ours, which is hardly ever exact.
TEST(InferHost, TrapsNothing) {
  for (const Case& one : cases()) {
    const int traps = FE_INEXACT | FE_INVALID | FE_OVERFLOW | FE_UNDERFLOW;
    feclearexcept(FE_ALL_EXCEPT);
    ASSERT_NE(feenableexcept(traps), -1);
    const std::vector<Answer> answers = all_answers(one.file, one.frames);
    EXPECT_EQ(fegetexcept(), traps);
    fedisableexcept(traps);
    expect_same_bits(answers, one.expected);
  }
}

TEST(InferHost, TakesNull) {
  const host::ScratchFolder folder;
  host::write_onnx(folder / "slip.onnx", bounded_model("4-3-3", nn::ScalingKind::frame, true));
  tactel_estimator* estimator = tactel_load((folder / "slip.onnx").c_str());
  ASSERT_NE(estimator, nullptr) << tactel_error();
  EXPECT_STREQ(tactel_error(), "");
  const float frame[4] = {-0.2f, -0.1f, 0.05f, 0.02f};
  tactel_history* history = tactel_history_create(estimator);

  const auto refuses = [](const tactel_answer& answer, const char* argument) {
    EXPECT_EQ(answer.status, uint32_t{TACTEL_WRONG_SIZE});
    EXPECT_TRUE(std::isnan(answer.slip_index) && std::isnan(answer.slip_upper));
    EXPECT_THAT(tactel_error(), HasSubstr(argument));
  };
  refuses(tactel_estimate(nullptr, frame, 4), "tactel_estimate: no estimator");
  refuses(tactel_estimate(estimator, nullptr, 4), "tactel_estimate: no frame");
  refuses(tactel_history_estimate(nullptr, frame, 4), "no history");
  refuses(tactel_history_estimate(history, nullptr, 4), "tactel_history_estimate: no frame");
  for (const auto& [e, f] : {std::pair<tactel_estimator*, const float*>{nullptr, frame}, {estimator, nullptr}}) {
    tactel_answer out[2] = {};
    tactel_estimate_all(e, f, 2, out);
    refuses(out[0], "tactel_estimate_all"), refuses(out[1], "tactel_estimate_all");
  }
  tactel_estimate_all(estimator, frame, 1, nullptr);
  tactel_estimate_all(nullptr, nullptr, 0, nullptr);
  EXPECT_EQ(tactel_inputs(nullptr), 0u);
  EXPECT_THAT(tactel_error(), HasSubstr("tactel_inputs"));
  EXPECT_EQ(tactel_alarm_create(nullptr, nullptr), nullptr);
  EXPECT_THAT(tactel_error(), HasSubstr("tactel_alarm_create: no estimator"));
  tactel_alarm_options rules = tactel_alarm_defaults();
  rules.hold = 0;
  EXPECT_EQ(tactel_alarm_create(estimator, &rules), nullptr);
  EXPECT_THAT(tactel_error(), HasSubstr("hold: 0"));
  rules = {.at = 0, .touch = 0.1, .widest = INFINITY, .hold = 2, .ignore_unlike = 0};  // at: of any S above 0
  tactel_alarm* alarm = tactel_alarm_create(estimator, &rules);
  ASSERT_NE(alarm, nullptr) << tactel_error();
  refuses(tactel_alarm_next(nullptr, frame, 4).answer, "no alarm");
  const float touching[4] = {-0.2f, -0.1f, 0.05f, 0.02f}, light[4] = {-0.05f, 0, 0, 0};
  EXPECT_EQ(tactel_alarm_next(alarm, light, 4).contact, 0);
  const tactel_alarm_answer first = tactel_alarm_next(alarm, touching, 4),
                            second = tactel_alarm_next(alarm, touching, 4);
  EXPECT_EQ(first.contact, 1);
  EXPECT_EQ(first.rest, -1);
  EXPECT_TRUE(std::isnan(first.moved));
  EXPECT_EQ(first.answer.slip_index, tactel_estimate(estimator, touching, 4).slip_index);
  EXPECT_EQ(first.acted_on, first.answer.slip_upper);
  EXPECT_EQ(second.on, 1);
  EXPECT_EQ(tactel_alarm_friction(alarm, 0.5, 0.1), 0);
  EXPECT_THAT(tactel_error(), HasSubstr("does not take friction"));
  EXPECT_EQ(tactel_alarm_friction(nullptr, 0.5, 0.1), 0);
  EXPECT_TRUE(std::isnan(tactel_alarm_slides(alarm)) && std::isnan(tactel_alarm_slides(nullptr)));
  tactel_alarm_clear(alarm);
  tactel_alarm_clear(nullptr);
  EXPECT_EQ(tactel_alarm_next(alarm, touching, 4).on, 0) << "one of two frames";
  tactel_alarm_free(alarm);
  tactel_alarm_free(nullptr);
  rules = {.at = 0.05f, .touch = 0.01, .widest = INFINITY, .hold = 1, .signal = TACTEL_MOVED};
  tactel_alarm* moved = tactel_alarm_create_moved(2, 2, &rules);
  ASSERT_NE(moved, nullptr) << tactel_error();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(tactel_alarm_next(moved, frame, 4).rest, i == 9);
  const float slid[4] = {-0.2f, -0.1f, 0.08f, 0.02f};  // 0.03 over 0.3
  const tactel_alarm_answer said = tactel_alarm_next(moved, slid, 4);
  EXPECT_NEAR(said.moved, 0.1, 1e-6);
  EXPECT_EQ(said.on, 1);
  tactel_alarm_rest(moved);
  tactel_alarm_rest(nullptr);
  EXPECT_EQ(tactel_alarm_next(moved, slid, 4).rest, 0);
  EXPECT_EQ(tactel_alarm_next(moved, slid, 4).on, 0);
  tactel_alarm_free(moved);
  EXPECT_EQ(tactel_history_create(nullptr), nullptr);
  EXPECT_THAT(tactel_error(), HasSubstr("tactel_history_create"));
  EXPECT_EQ(tactel_load(nullptr), nullptr);
  EXPECT_THAT(tactel_error(), HasSubstr("tactel_load"));
  tactel_history_clear(nullptr);
  tactel_history_free(nullptr);
  tactel_free(nullptr);

  EXPECT_EQ(tactel_estimate(estimator, frame, 4).status, uint32_t{TACTEL_OK});
  EXPECT_EQ(tactel_history_estimate(history, frame, 4).status, uint32_t{TACTEL_OK});
  tactel_history_free(history);
  tactel_free(estimator);
}

TEST(InferHost, RefusesANameWithANulByte) {
  const host::ScratchFolder folder;
  const std::string path = (folder / "slip.onnx").string();
  host::write_onnx(path, bounded_model("4-3-3", nn::ScalingKind::frame, true));
  EXPECT_NO_THROW(SlipEstimator::load(path));
  EXPECT_THAT([&] { SlipEstimator::load(path + std::string("\0x", 2)); },
              ::testing::ThrowsMessage<InputError>(HasSubstr(path + ": goes on behind a NUL byte")));
}

}  // namespace infer_host_test
