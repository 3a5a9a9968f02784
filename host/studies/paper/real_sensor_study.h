// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "host/networks/network_training.h"
#include "host/studies/paper/real_sensor.h"
#include "host/studies/study_report.h"

namespace tactel::host {

/// The 16-16-8-1 network of section VI, trained on 25 of the 105 contacts and judged on 11 others. The paper does
/// not name them. Several draws are therefore trained, each from several initial weights.
inline constexpr std::size_t paper_examples = 25, paper_recalls = 11;
const nn::Topology& real_topology();

/// Contacts by their indices in real_contacts().
struct ContactDraw {
  std::vector<std::uint32_t> learning, recall;  ///< disjoint
  std::vector<std::uint32_t> unseen;            ///< all contacts outside of learning, the recall set first
};
/// Returns the contacts in the order of presentation_order(permuted, draw, 0, contacts): the first 11 are
/// recalled, the next 25 learned.
ContactDraw draw_contacts(std::uint64_t draw, std::uint32_t contacts);

/// Returns the rows of a set in this order.
nn::FrameSet chosen_rows(const nn::FrameSet& set, const std::vector<std::uint32_t>& rows);

/// Inputs of the networks: the stresses, or records of them.
enum class RealData { stresses, records };
const char* name(RealData data);

struct RealSensorCase {
  RealData data = RealData::stresses;
  nn::ScalingKind scaling = nn::ScalingKind::set;
};
/// Errors of one case's networks, [draws][seeds].
struct RealSensorResult {
  RealSensorCase what;
  Reports learning, recalling, unseen;
  double learnt = 0;  ///< share of the networks that reached the stop error
};

struct RealSensorOptions {
  std::size_t draws = 20;  ///< of the contacts to learn and to recall
  std::size_t seeds = 8;   ///< initial weights on each draw
  nn::OnlineOptions training;
  Progress progress;  ///< networks; false stops
};

struct RealSensorStudy {
  RealSensorChoice choice;
  std::vector<RealContact> contacts;
  std::vector<fem::ContactSolution> solutions;  ///< [contacts]
  nn::FrameSet ideal;                           ///< [contacts]
  std::vector<float> records;                   ///< read_records of the first draw
  std::vector<RealSensorResult> results;        ///< both data, both scalings
  Reports angle_alone;                          ///< [draws] of the recall sets
  RealSensorOptions options;
  double seconds = 0;
};

/// Solves the contacts and trains all cases. Sensor, presses and noise of draw d have the seed d. Returns none
/// where progress stopped it.
std::optional<RealSensorStudy> study_real_sensor(Executor& executor, const RealSensorChoice& choice,
                                                 const RealSensorOptions& options);

/// Returns the errors of an estimator with a perfect force angle but no knowledge of mu. For each angle it
/// answers the middle of the possible slippage indices. [contacts]
std::vector<double> errors_by_angle_alone(const std::vector<RealContact>& contacts);

/// Returns section6.json: the choice, and for each case the errors on the learned contacts, on the 11 recalled
/// and on all others, as in table2.json; on the last also by indenter.
nlohmann::ordered_json real_sensor_json(const RealSensorStudy& study);

/// Adds to the report a record and its sample, and errors over draws and seeds, and by indenter.
void report_real_sensor(Page& page, const RealSensorStudy& study);

}  // namespace tactel::host
