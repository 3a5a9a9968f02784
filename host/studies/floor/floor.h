// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/device/executor.h"
#include "host/scenes/scene_source.h"
#include "nn/frame_history.h"
#include "nn/frame_likelihood.h"
#include "nn/model.h"

namespace tactel::host {

/// How well S can be read at all from the frames of a sweep's contacts: the floor of the mean of |error of S|. It lies
/// between two numbers.
/// Below: a bank of rows is drawn from the sweep, and a reading of one of them. The estimator knows the bank and asks
/// only which row it was: it answers the weighted median of S, with the density of the reading under each row as its
/// weight, which no estimator can beat there. To know the bank is to know more than the sweep: its error is below that
/// of every estimator on the sweep, and rises to the floor as the bank grows. Above: the same weighted median, of
/// readings of contacts that are not in the bank. That is an estimator, and its error is therefore above the floor. Its
/// weights are flattened by a factor (`spread`) that half of the readings choose; the other half judge it. At little
/// noise no bank is dense enough, and the two numbers stand far apart. Each row then has an estimate of its own:
/// nn::linear_error, with derivatives by the drawn numbers, those of irregular paths included, each over its range. It
/// is no bound. It holds the shape and what is chosen from a list as known, and S as linear: it is too small where two
/// shapes look alike, and where noise is large.

/// Rows of contacts with S, for the floor.
struct FrameBank {
  nn::RowMatrix<float> frames;                       ///< [rows, ReadingModel::size()] MPa, newest frame first
  std::vector<float> largest{};                      ///< [rows] MPa, over which the noise is; empty: newest frame's
  std::vector<float> slip_index;                     ///< [rows]
  std::vector<std::vector<std::uint16_t>> class_of;  ///< [families][rows] place in ClassFamily::classes
  std::size_t rows() const { return slip_index.size(); }
};
/// A way of dividing contacts into classes.
struct ClassFamily {
  std::string name;
  std::vector<std::string> classes;
};

/// Mean of |error of S| over readings.
struct FloorError {
  double mean = 0, standard_error = 0;
  std::size_t readings = 0;
};

/// Floor of a class of contacts. The estimator below is told the class; the one above is not.
struct FloorClass {
  std::size_t family_number = 0;
  std::uint16_t number = 0;  ///< place in its family
  std::string family, name;
  FloorError lower, estimate, upper;
  std::vector<FloorError> networks;  ///< in their order
};
struct FloorStep {
  std::size_t bank = 0;  ///< rows
  double lower = 0, upper = 0;
};
struct Floor {
  FloorClass all;
  std::vector<FloorClass> classes;     ///< those with readings, by family
  std::vector<FloorStep> convergence;  ///< by size of the bank, the whole one last
  std::size_t bank = 0;                ///< rows
  double spread = 1;                   ///< by which the estimator above flattens its weights
  double seconds = 0;
};

struct FloorOptions {
  double noise = 0.01, gain = 0;
  bool noise_of_contact = false;  ///< noise is over the largest |stress| of the contact, else of the newest frame
  nn::InputHistory history{};     ///< frames of a reading, as a network's input has them
  std::size_t bank = 200'000;     ///< rows, at least
  std::size_t readings = 2000;  ///< for the number below; as many choose and judge the one above, and have an estimate
  std::uint64_t seed = 1;       ///< of noise and gains
  Progress progress{};          ///< readings; false stops
};

/// Returns the floor of a bank and of readings of rows outside of it. Networks answer
/// the readings that judge the number above; those with one frame as input get the newest. None where progress stopped
/// it. Throws ValueError for banks without rows and networks of another width.
std::optional<Floor> floor_of(Executor& executor, const FrameBank& bank, const FrameBank& outside,
                              const nn::ReadingModel& model, const std::vector<ClassFamily>& families,
                              std::span<const nn::Model> networks, const FloorOptions& options);

/// Simulates both banks from a sweep, and returns their floor by indenter, by elements or nodes that touch, and by
/// tactels with more than 5 % of the largest normal stress. Contacts of the bank come first, those outside of it
/// follow. Frames of a reading are those that nn::FrameHistory keeps of the frames without noise; a [transducer] of the
/// sweep is not applied. Throws ConfigError for a listed sweep, or where no row has normal stress.
std::optional<Floor> measure_floor(Executor& executor, const SceneSource& sweep, std::span<const nn::Model> networks,
                                   const FloorOptions& options);

/// Returns the smallest value below or at which half of the weight lies. values: increasing.
double weighted_median(std::span<const float> values, std::span<const float> weights);

/// A skin and how it is read, with its floor: a line of a design table.
struct SkinFloor {
  int tactels = 0;
  double pitch = 0, thickness = 0;  ///< mm
  FloorOptions options;
  Floor floor;
};
/// Returns a line a skin: tactels, pitch, thickness, frames, noise, gains and the floor of all contacts.
std::string skin_table(std::span<const SkinFloor> skins, const std::vector<std::string>& networks);

std::string floor_table(const Floor& floor, const FloorOptions& options, const std::vector<std::string>& networks);
nlohmann::ordered_json to_json(const Floor& floor, const FloorOptions& options,
                               const std::vector<std::string>& networks);
nlohmann::ordered_json to_json(std::span<const SkinFloor> skins, const std::vector<std::string>& networks);

}  // namespace tactel::host
