// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fem/layer/sensor_family.h"
#include "fem/scene.h"
#include "host/scenes/contact_parameters.h"
#include "host/scenes/distribution.h"
#include "host/scenes/irregular_load.h"
#include "host/scenes/ladder.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// The contacts of a sweep file: contact k is a function of the file, its seed and k alone.
///   [sweep]  contacts = 100000, seed = 7, sensors = 16
///   [sensor], [indenter], [contact], [load] as in a scene file. Of repeated tables ([[indenter]] ...) each contact
///   draws one, in proportion to its `weight` (defaults to 1). Numbers may be distributions.
/// A [sensor] with distributions gives `sensors` sensors, drawn once: each requires a condensation. Without `sensors`,
/// and on patches, every contact draws its own poisson, thickness, young and length.
class SceneSource {
 public:
  /// `seed`: takes the place of the file's. Throws ConfigError with file, line, key, value and the allowed values.
  static SceneSource read(const std::filesystem::path& path, std::optional<std::uint64_t> seed = {});
  /// Listed scenes, as the sets of the paper; `kinds`: [scenes] indices in kind_names.
  SceneSource(std::vector<fem::Scene> scenes, std::vector<std::uint16_t> kinds, std::vector<std::string> kind_names);
  /// Sets the measuring chain of the stresses; `seed` draws its noise.
  void measure_with(const nn::Transducer& transducer, std::uint64_t seed) { transducer_ = transducer, seed_ = seed; }
  /// Sets whether the load steps of the pressing are rows, too.
  void give_press_rows(bool rows) { press_rows_ = rows; }
  bool press_rows() const { return press_rows_; }

  std::uint64_t contacts() const { return contacts_; }
  /// Returns true where contact(k) is defined beyond contacts(): for drawn contacts, not for listed ones.
  bool endless() const { return listed_.empty(); }
  std::uint64_t seed() const { return seed_; }
  int tactels() const;
  /// Returns the model of the rung (model_on); without one, that of the file.
  fem::SurfaceModel model() const { return model_; }
  const nn::Transducer& transducer() const { return transducer_; }
  /// Returns the source of this source's contacts with one of their drawn numbers changed, for derivatives by finite
  /// differences. Its contact k is contact k / n of this source, n = changes(): as it is where k % n = 0, else with the
  /// (k % n)-th of the numbers that are drawn uniformly or log-uniformly moved by `shift` of its range
  /// (DrawKey::moved); those of irregular paths come last. What is chosen from a list, counts, normal numbers and the
  /// slopes of random profiles stay. Of drawn contacts only.
  SceneSource changed(double shift) const;
  std::uint64_t changes() const { return 1 + moved_.size() + moved_of_path_; }
  /// Returns the kinds of indenters: one for each [[indenter]].
  const std::vector<std::string>& kind_names() const { return kind_names_; }

  struct Contact {
    fem::Scene scene;
    std::uint16_t kind = 0;  ///< index in kind_names
  };
  /// Returns contact k < contacts(), or any k where endless(). Throws ValueError where drawn numbers contradict
  /// each other.
  Contact contact(std::uint64_t k) const;
  /// Models contacts and sensors by the rung, from this call on. Throws ConfigError for a mesh where each contact draws
  /// its own sensor.
  void model_on(const Rung& rung);
  /// Returns the files that the sweep file names (measured profiles), each with the checksum of its numbers.
  std::vector<std::pair<std::string, std::string>> files() const;
  /// Returns every sensor of the contacts; where each contact draws its own, the tables that they are drawn from with
  /// the smallest number of each distribution.
  const std::vector<fem::Sensor>& sensors() const { return sensors_; }
  /// Returns what a set keeps of each contact (`/parameters`).
  ContactParameters parameters() const;
  /// Returns the places of the tactels, [tactels] mm along the array; empty where they differ between contacts.
  std::vector<float> tactel_x() const;
  /// Returns the range of the sensors where each contact draws its own.
  const std::optional<fem::SensorRange>& own_sensors() const { return own_sensors_; }

  /// A number to draw and its address. `number` distinguishes the draws of a contact.
  struct NumberDraw {
    std::uint32_t number = 0;
    Distribution distribution;
    double& (*place)(fem::Scene&, int) = nullptr;
    int index = 0;
  };
  /// A random convex profile: `points` over 2 half_width, slopes in increasing order, the highest point at `height`.
  struct RandomProfile {
    int points = 0;
    std::uint32_t number = 0;
    NumberDraw half_width, height;
  };
  /// One of several tables of a name.
  struct Alternative {
    fem::Scene scene;  ///< of which the table's own part counts
    std::vector<NumberDraw> draws;
    std::optional<RandomProfile> profile;
    std::optional<NumberDraw> slip_index;  ///< load.slip_index: the angle is chosen to give this S
    std::optional<IrregularLoad> irregular;
  };
  /// All tables of a name, with their weights.
  struct Part {
    std::vector<Alternative> alternatives;
    std::vector<double> weights;
    std::uint32_t number = 0;
  };

 private:
  friend class SweepReader;
  SceneSource() = default;

  Contact drawn_contact(std::uint64_t k) const;

  std::optional<Rung> rung_;
  fem::SurfaceModel model_ = fem::SurfaceModel::mesh;
  std::uint64_t contacts_ = 0, seed_ = 0;
  nn::Transducer transducer_;
  bool press_rows_ = false;
  std::vector<std::string> kind_names_;
  std::vector<fem::Scene> listed_;
  std::vector<std::uint16_t> listed_kinds_;
  Part indenter_, contact_, load_;
  Part sensor_;  ///< where each contact draws its own
  std::optional<fem::SensorRange> own_sensors_;
  std::string file_;  ///< for errors
  std::vector<fem::Sensor> sensors_;
  std::vector<double> sensor_weights_;
  std::vector<std::uint32_t> moved_;  ///< indices of the numbers that `changed` moves
  std::uint32_t moved_of_path_ = 0;   ///< numbers of the longest irregular path, where `changed` moves them
  double shift_ = 0;
};

}  // namespace tactel::host
