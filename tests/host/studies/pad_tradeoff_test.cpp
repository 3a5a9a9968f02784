// SPDX-License-Identifier: Apache-2.0

// Error against speed of the rungs of pads, and its report.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "host/studies/tradeoff/tradeoff.h"
#include "host/support/errors.h"

namespace tactel::host::pad_tradeoff_test {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

MeasuredModel model(const char* rung, double speed, double S) {
  return {.rung = rung_named<PadRung>(rung),
          .error = {.median = {.S = S / 4}, .most95 = {.S = S, .Q = 0.5}, .largest = {.S = 2 * S}},
          .steps_per_second = speed};
}

// pad-16 is slower than pad-24 and no better; nothing that is faster than the reference is as good.
TEST(TradeoffReport, OfPads) {
  Tradeoff tradeoff{.mix = "contacts",
                    .device = "device",
                    .definitions = "what they mean",
                    .judge_error = 0.002,
                    .models = {model("pad-8", 2e5, 0.04), model("pad-16", 1e3, 0.02), model("pad-24", 2e3, 0.02),
                               model("reference", 0.5, 0.002)}};
  mark_front(tradeoff.models);
  const auto json = to_json(tradeoff);
  std::vector<bool> front;
  for (const auto& of : json["models"]) front.push_back(of["front"]);
  EXPECT_THAT(front, ElementsAre(true, false, true, true));
  EXPECT_EQ(json["models"][0]["model"].dump(), R"({"name":"pad-8","cells":8,"increments":2})");
  EXPECT_EQ(json["models"][0]["error"]["S"].dump(), R"({"median":0.01,"most95":0.04,"largest":0.08})");
  EXPECT_THAT(tradeoff_table(tradeoff), AllOf(HasSubstr("pad-24: 24 x 24 cells, 8 increments *"),
                                              HasSubstr("    2 k |"), HasSubstr("own error in S below 0.002")));
  EXPECT_THAT(tradeoff_page(tradeoff), AllOf(HasSubstr("what they mean"), HasSubstr("Fastest: pad-24 (2 k load")));
  const Figure figure = tradeoff_figure(tradeoff);
  ASSERT_EQ(figure.panels.at(0).series.size(), 1u);  // without the reference
  EXPECT_THAT(figure.panels[0].series[0].names, ElementsAre("pad-16", "pad-24", "pad-8"));
  EXPECT_THAT(figure.panels[0].series[0].y, ElementsAre(0.02, 0.02, 0.04));
}

TEST(PadTradeoff, Stops) {
  Executor executor{Device()};
  std::size_t asked = 0;
  const auto stop = [&](std::size_t, std::size_t total) {
    ++asked;
    EXPECT_EQ(total, 12u);  // scenes and rungs
    return false;
  };
  EXPECT_THROW(measure_pad_tradeoff(executor, {.scenes = 8, .progress = stop}), Stopped);
  EXPECT_EQ(asked, 1u);
}

// Cells converge: three times as many a side have at most half the error, whatever scenes are drawn.
TEST(PadTradeoffNightly, ErrorsFallWithTheCells) {
  Executor executor{Device()};
  const Tradeoff tradeoff = measure_pad_tradeoff(executor, {.scenes = 9});
  ASSERT_EQ(tradeoff.models.size(), all_rungs<PadRung>().size());
  const MeasuredModel &coarse = tradeoff.models[0], &fine = tradeoff.models[3];
  for (const auto member : error_members) {
    EXPECT_LT(2 * (fine.error.median.*member), coarse.error.median.*member);
    EXPECT_GT(fine.error.median.*member, 0);
  }
  EXPECT_GT(coarse.steps_per_second, 10 * fine.steps_per_second);  // 3^4 / 2 in sweeps of all pairs
  for (const MeasuredModel& of : tradeoff.models) EXPECT_EQ(of.unsolved, 0);
}

}  // namespace tactel::host::pad_tradeoff_test
