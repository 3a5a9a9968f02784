// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <random>

#include "fem/condensation.h"
#include "fem/number_text.h"
#include "fem/processor.h"

namespace tactel::fem {
namespace {

namespace fs = std::filesystem;

// Raised whenever the layout below changes.
constexpr std::uint32_t format_version = 1;

/// Fowler, Noll and Vo's FNV-1a, 64 bits (RFC 9923). Each step is invertible, so a change of any one byte always shows.
std::uint64_t checksum(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return hash;
}

std::string hexadecimal(std::uint64_t number) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(number));
  return text;
}

template <class Number>
void append(std::string& bytes, const Number& number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

/// All that C, T and the tactel stresses depend on, to the last digit: not E, which only scales. TACTEL_FEM_FINGERPRINT
/// is made of the sources that form them and of the compiler's options; the processor orders sums. Another formula or
/// rounding, another key.
std::string key_text(const Sensor& s) {
  return "tactel condensation\nbuild " TACTEL_FEM_FINGERPRINT "\nprocessor " + processor_text() + "\nlength " +
         number_text(s.length) + "\nthickness " + number_text(s.thickness) + "\npoisson " + number_text(s.poisson) +
         "\ncolumns " + std::to_string(s.columns) + "\nrows " + std::to_string(s.rows) + "\ngrading " +
         number_text(s.grading) + "\nelement " + name(s.element) + "\ntactels " + std::to_string(s.tactels) +
         "\nspan " + number_text(s.span()) + "\nwidth " + number_text(s.tactel_width) + "\nstress " + name(s.stress) +
         "\n";
}

/// A result of the right sizes for this sensor, to be filled.
Condensation empty_condensation(const Sensor& s) {
  const Eigen::Index loads = 2 * s.columns, base_nodes = s.element == Element::q8 ? 2 * s.columns - 1 : s.columns;
  return {Eigen::MatrixXd(loads, loads),         Eigen::MatrixXd(2 * base_nodes, loads),
          Eigen::MatrixXd(2 * s.tactels, loads), Eigen::VectorXd(s.columns),
          Eigen::VectorXd(base_nodes),           Eigen::VectorXd(s.tactels)};
}

/// Calls `visit(data, count)` for each array in the file's order.
template <class Result, class Visit>
void for_each_array(Result& c, Visit visit) {
  visit(c.compliance.data(), c.compliance.size());
  visit(c.base_force.data(), c.base_force.size());
  visit(c.tactel_stress.data(), c.tactel_stress.size());
  visit(c.surface_x.data(), c.surface_x.size());
  visit(c.base_x.data(), c.base_x.size());
  visit(c.tactel_x.data(), c.tactel_x.size());
}

/// What a file for this sensor begins with: magic, version, byte order, key, number of values. The reader builds it
/// anew and compares, so that nothing a foreign file claims is ever believed.
std::string header(const Sensor& sensor) {
  const std::string key = key_text(sensor);
  std::string bytes = "TACTEL\r\n";
  append(bytes, format_version);
  append(bytes, std::uint32_t{0x01020304});
  append(bytes, std::uint64_t{key.size()});
  bytes += key;
  const Condensation shape = empty_condensation(sensor);
  for_each_array(shape, [&](const double*, Eigen::Index count) { append(bytes, std::int64_t{count}); });
  return bytes;
}

std::string file_content(const Sensor& sensor, const Condensation& result) {
  std::string bytes = header(sensor);
  for_each_array(result, [&](const double* data, Eigen::Index count) {
    bytes.append(reinterpret_cast<const char*>(data), static_cast<std::size_t>(count) * sizeof(double));
  });
  append(bytes, checksum(bytes));
  return bytes;
}

/// The whole file if it has exactly the wanted size, else nothing.
std::optional<std::string> read_file(const fs::path& path, std::size_t size) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) != size || error) return {};
  std::ifstream file(path, std::ios::binary);
  std::string bytes(size, '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return {};
  return bytes;
}

/// The cached result, or nothing where the file is missing, truncated, damaged, foreign or of another version.
std::optional<Condensation> load(const Sensor& sensor, const fs::path& path) {
  Condensation result = empty_condensation(sensor);
  const std::string begin = header(sensor);
  std::size_t values = 0;
  for_each_array(result, [&](double*, Eigen::Index count) { values += static_cast<std::size_t>(count); });
  const std::size_t sum_at = begin.size() + values * sizeof(double);
  std::optional<std::string> bytes = read_file(path, sum_at + sizeof(std::uint64_t));
  if (!bytes || bytes->compare(0, begin.size(), begin) != 0) return {};
  std::uint64_t written;
  std::memcpy(&written, bytes->data() + sum_at, sizeof written);
  bytes->resize(sum_at);
  if (checksum(*bytes) != written) return {};
  const char* from = bytes->data() + begin.size();
  for_each_array(result, [&](double* data, Eigen::Index count) {
    std::memcpy(data, from, static_cast<std::size_t>(count) * sizeof(double));
    from += static_cast<std::size_t>(count) * sizeof(double);
  });
  return result;
}

bool write_new_file(const fs::path& path, const std::string& bytes) {
  // "x": never over a file that someone else is writing.
  std::FILE* file = std::fopen(path.c_str(), "wbx");
  if (!file) return false;
  const bool whole = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  return (std::fclose(file) == 0) && whole;
}

/// Under a name of its own, then renamed: readers and other writers see a whole file or none. Failure leaves no trace.
void store(const fs::path& path, const std::string& bytes) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  std::random_device random;
  const std::uint64_t unique = (std::uint64_t{random()} << 32) ^ random();
  const fs::path temporary = path.string() + "." + hexadecimal(unique) + ".tmp";
  if (write_new_file(temporary, bytes))
    fs::rename(temporary, path, error);
  else
    error = std::make_error_code(std::errc::io_error);
  if (error) fs::remove(temporary, error);
}

}  // namespace

Condensation condense_cached(const Sensor& sensor, const fs::path& directory) {
  sensor.validate();
  const fs::path path = directory / ("block-" + hexadecimal(checksum(key_text(sensor))) + ".condensation");
  if (auto cached = load(sensor, path)) return *std::move(cached);
  Condensation result = condense(sensor);
  if (!directory.empty()) store(path, file_content(sensor, result));
  return result;
}

}  // namespace tactel::fem
