// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

#include "host/scenes/scene_source.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {

inline constexpr const char* press_rows_words = "true (the steps of the pressing are rows, too) or false";

/// Reads the sweep files of SceneSource. Each of the tables [sensor], [indenter], [contact] and [load] becomes
/// alternatives. An alternative is a scene, with the smallest number of each distribution, and the distributions.
/// The strict readers of scene files check that scene.
class SweepReader {
 public:
  /// `seed`: takes the place of the file's.
  explicit SweepReader(const std::filesystem::path& path, std::optional<std::uint64_t> seed = {});
  /// The same of a file that is open already.
  explicit SweepReader(TomlFile file, std::optional<std::uint64_t> seed = {});
  SceneSource read();

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
  fem::Scene read_scene(const TomlFile& file) const;
  SceneSource::Part part(const std::string& name);
  SceneSource::Alternative alternative(const std::string& name, std::size_t chosen, const toml::table& table);
  SceneSource::NumberDraw number_draw(const Found& found, const std::string& shape);
  void check_ends(const SceneSource::Alternative& alternative, const std::vector<Found>& found) const;
  void take_random_profile(const toml::table& table, SceneSource::Alternative& into);
  void take_irregular(const toml::table& load, const toml::node& node, SceneSource::Alternative& into) const;
  SceneSource::NumberDraw whole_draw(const std::string& key, const toml::node* node, const char* allowed);
  void read_sensors(SceneSource& source, int count);
  bool draws_own_sensors(const SceneSource::Part& part) const;
  void read_own_sensors(SceneSource& source, SceneSource::Part&& part);

  TomlFile file_;
  std::optional<std::uint64_t> seed_;
  std::uint32_t next_ = 0;  ///< number of the next draw
};

}  // namespace tactel::host
