// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>

#include "host/scenes/scene_source.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {

inline constexpr const char* press_rows_words = "true (the steps of the pressing are rows, too) or false";

/// Reads the sweep files of SourceOf<Scene>. Each of the tables [sensor], [indenter], [contact] and [load] becomes
/// alternatives. An alternative is a scene, with the smallest number of each distribution, and the distributions.
/// The strict readers of scene files check that scene.
template <class Scene>
class SweepReaderOf {
  using Source = SourceOf<Scene>;
  using Alternative = typename Source::Alternative;
  using NumberDraw = typename Source::NumberDraw;
  using Part = typename Source::Part;

 public:
  /// `seed`: takes the place of the file's.
  explicit SweepReaderOf(TomlFile file, std::optional<std::uint64_t> seed = {});
  Source read();

 private:
  /// A distribution in the file.
  struct Found {
    std::string key;  ///< "indenter.radius"
    int index = -1;   ///< position in a list; -1: a single number
    Distribution distribution;
    const toml::node* node = nullptr;
  };

  std::vector<const toml::table*> tables(const std::string& name) const;
  std::vector<Found> distributions(const std::string& name, const toml::table& table) const;
  double weight(const std::string& name, const toml::table& table) const;
  TomlFile concrete(const std::string& name, std::size_t chosen) const;
  Scene read_scene(const TomlFile& file) const;
  Part part(const std::string& name);
  Alternative alternative(const std::string& name, std::size_t chosen, const toml::table& table);
  NumberDraw number_draw(const Found& found, const std::string& shape);
  void check_ends(const Alternative& alternative, const std::vector<Found>& found) const;
  void take_own_keys(const std::string& name, const toml::table& table, Alternative& into);  ///< of lines, of pads
  void take_random_profile(const toml::table& table, Alternative& into);
  const toml::table& table_of_path(const toml::table& load, const toml::node& node, const std::string& name) const;
  void take_irregular(const toml::table& load, const toml::node& node, Alternative& into) const;
  void check_whole(Source& source) const;
  void check_holds(const Source& source) const;
  void take_markers(Source& source) const;
  void take_maps(Source& source) const;
  NumberDraw whole_draw(const std::string& key, const toml::node* node, const char* allowed);
  void read_sensors(Source& source, int count);
  bool draws_own_sensors(const Part& part) const;
  void read_own_sensors(Source& source, Part&& part);

  TomlFile file_;
  std::optional<std::uint64_t> seed_;
  std::uint32_t next_ = 0;  ///< number of the next draw
};

template <>
void SweepReaderOf<fem::Scene>::take_own_keys(const std::string&, const toml::table&, SceneSource::Alternative&);
template <>
void SweepReaderOf<fem::PadScene>::take_own_keys(const std::string&, const toml::table&, PadSource::Alternative&);
template <>
void SweepReaderOf<fem::PadScene>::check_holds(const PadSource&) const;
template <>
void SweepReaderOf<fem::PadScene>::take_markers(PadSource&) const;
template <>
void SweepReaderOf<fem::PadScene>::take_maps(PadSource&) const;
template <>
void SweepReaderOf<fem::Scene>::check_whole(SceneSource&) const;
template <>
void SweepReaderOf<fem::PadScene>::check_whole(PadSource&) const;
template <>
void SweepReaderOf<fem::Scene>::read_own_sensors(SceneSource& source, SceneSource::Part&& part);
template <>
void SweepReaderOf<fem::PadScene>::read_own_sensors(PadSource& source, PadSource::Part&& part);
extern template class SweepReaderOf<fem::Scene>;
extern template class SweepReaderOf<fem::PadScene>;

}  // namespace tactel::host
