#include "host/training_directory.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/atomic_file.h"
#include "host/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

[[noreturn]] void refuse(const fs::path& path, const std::string& allowed) {
  throw ConfigError("command line", "--output", path.string(), allowed);
}

// Empty where it is missing or damaged.
json read_json(const fs::path& path) {
  std::ifstream in(path);
  json value = json::parse(in, nullptr, false);
  return value.is_object() ? value : json::object();
}

}  // namespace

bool TrainingDirectory::finished() const { return fs::exists(report()); }

bool TrainingDirectory::interrupted() const { return fs::exists(checkpoint()); }

std::vector<std::string> TrainingDirectory::own_networks() const {
  std::vector<std::string> files;
  for (const json& network : read_json(report()).value("networks", json::array()))
    if (network.is_object() && network.contains("file") && network["file"].is_string())
      files.push_back(fs::path(network["file"].get<std::string>()).filename());
  return files;
}

void TrainingDirectory::check(bool resume, bool force) const {
  std::error_code error;
  fs::create_directories(path_, error);
  if (error || !fs::is_directory(path_)) refuse(path_, "a directory, or one that can be made");
  check_writable("--output", report());
  if (resume) return;
  if (!force && finished())
    refuse(path_, "a directory without a finished training, or --force to train anew and write over it");
  if (!force && interrupted())
    refuse(path_,
           "a directory without an interrupted training, or --resume to go on with it, or --force to train anew");
  const std::vector<std::string> own = own_networks();
  for (const fs::directory_entry& entry : fs::directory_iterator(path_))
    if (entry.path().extension() == ".onnx" && std::ranges::find(own, entry.path().filename().string()) == own.end())
      refuse(path_, "a directory without networks of another origin (" + entry.path().filename().string() + ")");
}

void TrainingDirectory::expect_same(const std::string& fingerprint) const {
  if (read_json(report()).value("fingerprint", "") != fingerprint)
    throw ConfigError(report().string(), "fingerprint", "of another training",
                      "of this one (same set, networks, seeds, noise, options, precision and device lanes); or --force "
                      "to train anew, or another --output");
}

void TrainingDirectory::clear() const {
  for (const std::string& file : own_networks()) fs::remove(network(file));
  fs::remove(report());
  fs::remove(figure());
  remove_checkpoint();
}

void TrainingDirectory::remove_checkpoint() const {
  fs::remove(checkpoint());
  fs::remove(checkpoint().string() + ".part");  // of a writing that was killed
}

}  // namespace tactel::host
