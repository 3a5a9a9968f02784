// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "fem/layer/sensor_family.h"
#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"
#include "host/scenes/contact_parameters.h"
#include "host/scenes/distributed_keys.h"
#include "host/scenes/distribution.h"
#include "host/scenes/hold_load.h"
#include "host/scenes/irregular_load.h"
#include "host/scenes/ladder.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

template <class Scene>
class SweepReaderOf;

/// Returns the numbers of a sensor's frame.
inline int inputs_of(const fem::Sensor& sensor) { return 2 * sensor.tactels; }
inline int inputs_of(const fem::PadSensor& sensor) { return sensor.axes * sensor.tactels[0] * sensor.tactels[1]; }

/// Returns the markers of a scene, of pads.
inline std::optional<Markers> markers_of(const fem::Scene&) { return {}; }
inline std::optional<Markers> markers_of(const fem::PadScene& scene) { return scene.markers; }
inline std::optional<Camera> camera_of(const fem::Scene&) { return {}; }
inline std::optional<Camera> camera_of(const fem::PadScene& scene) { return scene.camera; }

/// What sweeps of lines and of pads have in common.
class ContactSource {
 public:
  /// Sets the measuring chain of the stresses; `seed` draws its noise.
  void measure_with(const nn::Transducer& transducer, std::uint64_t seed) { transducer_ = transducer, seed_ = seed; }
  /// Sets whether the load steps of the pressing are rows, too.
  void give_press_rows(bool rows) { press_rows_ = rows; }
  bool press_rows() const { return press_rows_; }
  std::uint64_t contacts() const { return contacts_; }
  /// Returns true where contact(k) is defined beyond contacts(): for drawn contacts, not for listed ones.
  bool endless() const { return endless_; }
  std::uint64_t seed() const { return seed_; }
  const nn::Transducer& transducer() const { return transducer_; }
  const std::vector<std::string>& kind_names() const { return kind_names_; }
  /// Returns the numbers of a frame.
  int inputs() const { return inputs_; }
  /// Returns the files that the sweep file names (measured profiles), each with the checksum of its numbers.
  const std::vector<std::pair<std::string, std::string>>& files() const { return files_; }

 protected:
  template <class Scene>
  friend class SweepReaderOf;
  std::uint64_t contacts_ = 0, seed_ = 0;
  bool endless_ = true, press_rows_ = false;
  int inputs_ = 0;
  nn::Transducer transducer_;
  std::vector<std::string> kind_names_;
  std::vector<std::pair<std::string, std::string>> files_;
};

/// The contacts of a sweep file: contact k is a function of the file, its seed and k alone.
///   [sweep]  contacts = 100000, seed = 7, sensors = 16
///   [sensor], [indenter], [contact], [load] as in a scene file. Of repeated tables ([[indenter]] ...) each contact
///   draws one, in proportion to its `weight` (defaults to 1). Numbers may be distributions.
/// A [sensor] with distributions gives `sensors` sensors, drawn once: each requires a condensation. Without `sensors`,
/// and on patches and pads, every contact draws its own poisson, thickness, young and length.
/// Scene: fem::Scene or fem::PadScene.
template <class Scene>
class SourceOf : public ContactSource {
 public:
  using Sensor = decltype(Scene::sensor);
  static constexpr bool of_lines = std::is_same_v<Scene, fem::Scene>;
  struct OwnPads {
    bool any_poisson = false;  ///< not only a few that stand in the file
  };
  /// The range of the sensors where each contact draws its own.
  using OwnSensors = std::conditional_t<of_lines, fem::SensorRange, OwnPads>;

  /// `seed`: takes the place of the file's. Throws ConfigError with file, line, key, value and the allowed values.
  static SourceOf read(const std::filesystem::path& path, std::optional<std::uint64_t> seed = {});
  /// Listed scenes, as the sets of the paper; `kinds`: [scenes] indices in kind_names.
  SourceOf(std::vector<Scene> scenes, std::vector<std::uint16_t> kinds, std::vector<std::string> kind_names);

  /// Returns the model of the rung (model_on); without one, that of the file. Of lines.
  fem::SurfaceModel model() const { return model_; }
  /// Returns, of each number that a contact draws, whether it grows steadily with its quantile: choices do not. A
  /// contact needs only the numbers of the alternatives that it draws.
  const std::vector<bool>& numbers() const { return numbers_; }
  /// Returns the source of the contacts with these quantiles in [0, 1), [contacts][numbers()], instead of drawn ones.
  /// Of drawn contacts only.
  SourceOf of_quantiles(std::span<const double> quantiles) const;
  /// Returns the kinds of indenters: one for each [[indenter]].
  const std::vector<std::string>& kind_names() const { return kind_names_; }

  struct Contact {
    Scene scene;
    std::uint16_t kind = 0;  ///< index in kind_names
  };
  /// Returns contact k < contacts(), or any k where endless(). Throws ValueError where drawn numbers contradict
  /// each other.
  Contact contact(std::uint64_t k) const;
  /// Models contacts and sensors by the rung, from this call on. Throws ConfigError for a mesh where each contact draws
  /// its own sensor. Of lines.
  void model_on(const Rung& rung);
  /// Returns every sensor of the contacts; where each contact draws its own, the tables that they are drawn from with
  /// the smallest number of each distribution.
  const std::vector<Sensor>& sensors() const { return sensors_; }
  /// Returns what a set keeps of each contact (`/parameters`).
  ContactParametersOf<Scene> parameters() const;
  /// Returns the places of the tactels, [tactels] mm along the array; empty where they differ between contacts. Of pads
  /// x is the fastest.
  std::vector<float> tactel_x() const;
  std::vector<float> tactel_y() const;  ///< of pads
  const std::optional<OwnSensors>& own_sensors() const { return own_sensors_; }
  /// Returns the markers of all contacts, of pads.
  std::optional<Markers> markers() const {
    return indenter_.alternatives.empty() ? std::nullopt : markers_of(indenter_.alternatives.front().scene);
  }
  /// Returns the camera that sees them, of pads.
  std::optional<Camera> camera() const {
    return indenter_.alternatives.empty() ? std::nullopt : camera_of(indenter_.alternatives.front().scene);
  }
  /// Returns whether contacts are grips that hold an object, [load.hold]. Of pads.
  bool holds() const { return !load_.alternatives.empty() && load_.alternatives.front().hold.has_value(); }
  /// Returns whether any of them has a rate.
  bool has_rate() const {
    return std::ranges::any_of(load_.alternatives, [](const auto& load) { return load.hold && load.hold->rate > 0; });
  }
  /// Returns how contact k of such a source is gripped, at the force of its scene's load.
  Hold hold(std::uint64_t k) const;

  /// A number to draw and its place. `number` distinguishes the draws of a contact.
  struct NumberDraw {
    std::uint32_t number = 0;
    Distribution distribution;
    NumberPlace<Scene> place = nullptr;
    int index = 0;
    void put(Scene& scene, double value) const { place(scene, index, value); }
  };
  /// A random convex profile: `points` over 2 half_width, slopes in increasing order, the highest point at `height`.
  struct RandomProfile {
    int points = 0;
    std::uint32_t number = 0;
    std::uint32_t slopes = 0;  ///< the first of their quantiles
    NumberDraw half_width, height;
  };
  /// One of several tables of a name.
  struct Alternative {
    Scene scene;  ///< of which the table's own part counts
    std::vector<NumberDraw> draws;
    std::optional<RandomProfile> profile;  ///< of lines, and the next
    std::optional<NumberDraw> slip_index;  ///< load.slip_index: the angle is chosen to give this S
    std::optional<IrregularLoad> irregular;
    std::optional<HoldLoad> hold;          ///< of pads, and the next
    std::optional<Unevenness> unevenness;  ///< of the face that a hold presses
    std::uint32_t path = 0;                ///< the first of the path's or the hold's quantiles
  };
  /// All tables of a name, with their weights.
  struct Part {
    std::vector<Alternative> alternatives;
    std::vector<double> weights;
    std::uint32_t number = 0;
  };

 private:
  friend class SweepReaderOf<Scene>;
  SourceOf() = default;

  DrawKey key_of(std::uint64_t k) const;
  Contact drawn_contact(std::uint64_t k) const;
  void lay_out_quantiles(std::size_t draws);

  std::optional<Rung> rung_;  ///< of lines, and the next
  fem::SurfaceModel model_ = fem::SurfaceModel::mesh;
  std::vector<Scene> listed_;
  std::vector<std::uint16_t> listed_kinds_;
  Part indenter_, contact_, load_;
  Part sensor_;  ///< where each contact draws its own
  std::optional<OwnSensors> own_sensors_;
  std::string file_;  ///< for errors
  std::vector<Sensor> sensors_;
  std::vector<double> sensor_weights_;
  std::vector<bool> numbers_;
  std::vector<double> quantiles_;  ///< [contacts][numbers()], of of_quantiles
};

template <>
void SourceOf<fem::Scene>::model_on(const Rung& rung);

using SceneSource = SourceOf<fem::Scene>;
using PadSource = SourceOf<fem::PadScene>;
extern template class SourceOf<fem::Scene>;
extern template class SourceOf<fem::PadScene>;

/// A sweep of either kind.
using AnySource = std::variant<SceneSource, PadSource>;
inline ContactSource& common(AnySource& source) {
  return std::visit([](auto& sweep) -> ContactSource& { return sweep; }, source);
}
inline const ContactSource& common(const AnySource& source) {
  return std::visit([](const auto& sweep) -> const ContactSource& { return sweep; }, source);
}

/// Returns true where the outermost tactels are points at the ends of the glued base, where the exact stress is
/// infinite: what they read depends on the model. Tactels of a width read a finite mean.
bool tactels_at_ends(const fem::Sensor& sensor);
/// The same of any sensor of a sweep.
bool tactels_at_ends(const SceneSource& source);

/// What commands say of such tactels, where contacts are solved on patches.
inline constexpr const char* tactels_at_ends_text =
    "the outermost tactels stand at the ends of the glued base, where the exact stress is infinite: what a network "
    "learns from them is the model's; sensor.tactel_span or sensor.tactel_width avoids it (docs/sweeps.md)";

}  // namespace tactel::host
