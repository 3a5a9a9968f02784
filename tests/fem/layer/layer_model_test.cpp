// SPDX-License-Identifier: Apache-2.0

// Tables of a sensor through the cache: the same bits, and nothing that a damaged file holds.
#include "fem/layer/layer_model.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "tests/fem/resealed.h"
#include "tests/scratch.h"

namespace tactel::fem::layer_model_test {

namespace fs = std::filesystem;

/// A short sensor, whose block has the fewest columns; `k` tells sensors apart.
Sensor short_sensor(int k = 0) { return {.length = 3.1 + 0.37 * k, .thickness = 1.5, .tactels = 3}; }

template <class Numbers>
bool same(const Numbers& a, const Numbers& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

bool same_bits(const LayerModel& a, const LayerModel& b) {
  return same(a.table.coefficients(), b.table.coefficients()) && same(a.sides.rows(), b.sides.rows()) &&
         same(a.sides.sign(), b.sides.sign()) && same(a.base.rows(), b.base.rows()) &&
         a.table.poisson() == b.table.poisson() && a.sides.left() == b.sides.left() &&
         a.sides.step() == b.sides.step() && a.base.left() == b.base.left() && a.base.step() == b.base.step() &&
         a.base.tactels() == b.base.tactels();
}

class LayerModelCache : public testing::Test {
 protected:
  /// Through the folder, past the model that layer_model keeps in memory.
  LayerModel model(const Sensor& sensor) const {
    layer_model(short_sensor(9), folder_ / "other");
    return layer_model(sensor, folder_ / "");
  }

  fs::path file() const {
    for (const auto& entry : fs::directory_iterator(folder_ / ""))
      if (entry.path().extension() == ".tables") return entry.path();
    return {};
  }

  std::string content() const { return text_of(file()); }
  void write_sealed(const std::string& bytes) const { std::ofstream(file(), std::ios::binary) << resealed(bytes); }

  const ScratchFolder folder_;
};

/// With `number` in the place of the last one: the last tactel's tau_xy by traction at the right end.
std::string with_last(std::string bytes, double number) {
  std::memcpy(bytes.data() + bytes.size() - 16, &number, 8);
  return bytes;
}

double last_of(const LayerModel& model) { return model.base.rows()(model.base.rows().rows() - 1, 4 * 3 - 1); }

TEST_F(LayerModelCache, GivesTheSameBits) {
  for (int k = 0; k < 3; ++k) {
    const LayerModel computed = layer_model(short_sensor(k), "");
    EXPECT_TRUE(same_bits(model(short_sensor(k)), computed)) << k;  // computes and writes
    EXPECT_TRUE(same_bits(model(short_sensor(k)), computed)) << k;  // reads
    EXPECT_EQ(model(short_sensor(k)).sensor, short_sensor(k));
  }
}

// A number that was changed under a right checksum comes back: so the file was read. For some lengths, since the number
// of places of a table is rounded.
TEST_F(LayerModelCache, IsReadFromTheFile) {
  const double marker = 12345;
  for (int k = 0; k < 5; ++k) {
    model(short_sensor(k));
    write_sealed(with_last(content(), marker));
    EXPECT_EQ(last_of(model(short_sensor(k))), marker) << k;
    fs::remove(file());
  }
}

TEST_F(LayerModelCache, BelievesNoDamagedFile) {
  const double right = last_of(model(short_sensor()));
  const std::string good = content();
  const auto find = [&] { return last_of(model(short_sensor())); };
  std::ofstream(file(), std::ios::binary) << with_last(good, 1);
  EXPECT_EQ(find(), right) << "checksum";
  EXPECT_EQ(content(), good) << "mended";
  fs::resize_file(file(), good.size() - 8);
  EXPECT_EQ(find(), right) << "truncated";
  write_sealed(with_last(good, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(find(), right) << "no number";
  std::string other_key = good;
  other_key[good.find("poisson 0.45") + 10] = '3';
  write_sealed(with_last(other_key, 1));
  EXPECT_EQ(find(), right) << "another sensor's";
}

// Of a sensor all counts but E and its mesh.
TEST_F(LayerModelCache, HasAFileForEachLayer) {
  const auto files_after = [&](auto change) {
    Sensor sensor = short_sensor();
    change(sensor);
    model(sensor);
    int files = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "")) files += entry.path().extension() == ".tables";
    return files;
  };
  EXPECT_EQ(files_after([](Sensor&) {}), 1);
  EXPECT_EQ(files_after([](Sensor& s) { s.young = 3, s.columns = 11, s.rows = 4, s.grading = 2; }), 1);
  EXPECT_EQ(files_after([](Sensor& s) { s.element = Element::q8, s.stress = StressRecovery::element; }), 1);
  EXPECT_EQ(files_after([](Sensor& s) { s.length = std::nextafter(s.length, 9); }), 2);
  EXPECT_EQ(files_after([](Sensor& s) { s.thickness = 1.25; }), 3);
  EXPECT_EQ(files_after([](Sensor& s) { s.poisson = 0.3; }), 4);
  EXPECT_EQ(files_after([](Sensor& s) { s.tactels = 4; }), 5);
  EXPECT_EQ(files_after([](Sensor& s) { s.tactel_span = 1.5; }), 6);
  EXPECT_EQ(files_after([](Sensor& s) { s.tactel_width = 0.5; }), 7);
  // A member added to Sensor must be added to the key, if the layer depends on it, and here.
  EXPECT_EQ(files_after([](Sensor& s) { s.layers = {{0.5, 1, 0.45}, {1, 2, 0.45}}; }), 8);
  EXPECT_EQ(files_after([](Sensor& s) { s.young = 4, s.layers = {{0.5, 2, 0.45}, {1, 4, 0.45}}; }), 8);
  EXPECT_EQ(files_after([](Sensor& s) { s.layers = {{0.5, 1, 0.4}, {1, 2, 0.45}}; }), 9);
  static_assert(sizeof(Sensor) == sizeof(double) * 6 + sizeof(int) * 6 + sizeof(std::optional<double>) +
                                      sizeof(std::vector<RubberLayer>));
}

}  // namespace tactel::fem::layer_model_test
