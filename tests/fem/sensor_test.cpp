// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/sensor.h"

#include <limits>

#include "expect_error.h"
#include "sensors.h"

namespace tactel::fem::sensor_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();

TEST(Sensor, AcceptsThePapersMeshesAndTheSmallest) {
  for (Element element : all_elements) {
    EXPECT_NO_THROW(validate(mesh_a(element, 0.4999)));
    EXPECT_NO_THROW(validate(mesh_b(element, 0)));
    Sensor smallest = mesh_b(element);
    smallest.columns = 3;
    smallest.rows = smallest.tactels = 2;
    EXPECT_NO_THROW(validate(smallest));
  }
}

TEST(Sensor, NamesWhatItRejects) {
  const auto rejects = [](auto member, auto value, const char* key, const char* printed, const char* allowed) {
    Sensor sensor;
    sensor.*member = value;
    expect_value_error([&] { validate(sensor); }, key, printed, allowed);
  };
  for (double bad : {0.0, -1.0, nan, infinity}) {
    rejects(&Sensor::length, bad, "sensor.length", "", "length in mm");
    rejects(&Sensor::thickness, bad, "sensor.thickness", "", "thickness in mm");
    rejects(&Sensor::young, bad, "sensor.young", "", "above 0");
    rejects(&Sensor::grading, bad, "sensor.grading", "", "bottom row's height");
  }
  for (double bad : {0.51, -0.1, nan, 1.0}) rejects(&Sensor::poisson, bad, "sensor.poisson", "", "0 <= poisson <= 0.5");
  rejects(&Sensor::poisson, 0.51, "sensor.poisson", "0.51", "");
  rejects(&Sensor::thickness, -1.5, "sensor.thickness", "-1.5", "");
  rejects(&Sensor::thickness, nan, "sensor.thickness", "nan", "");
  rejects(&Sensor::columns, 2, "sensor.columns", "2", "3 to 2001");
  rejects(&Sensor::columns, 1000000, "sensor.columns", "1000000", "3 to 2001");
  rejects(&Sensor::rows, 1, "sensor.rows", "1", "2 to 1001");
  rejects(&Sensor::tactels, 1, "sensor.tactels", "1", "2 to 10000");
  for (double bad : {-0.1, 1.0, nan}) rejects(&Sensor::tactel_width, bad, "sensor.tactel_width", "", "0 (a point)");
  for (double bad : {0.0, -1.0, 20.1, nan, infinity})
    rejects(&Sensor::tactel_span, bad, "sensor.tactel_span", "", "length in mm");
  rejects(&Sensor::element, static_cast<Element>(9), "sensor.element", "9", "q8");
  rejects(&Sensor::stress, static_cast<StressRecovery>(9), "sensor.stress", "9", "reaction");
}

TEST(Sensor, CallsElementsAndRecoveriesAsSceneFilesDo) {
  EXPECT_STREQ(name(Element::bbar), "bbar");
  EXPECT_STREQ(name(Element::q4), "q4");
  EXPECT_STREQ(name(Element::q4i), "q4i");
  EXPECT_STREQ(name(Element::q8), "q8");
  EXPECT_STREQ(name(StressRecovery::reaction), "reaction");
  EXPECT_STREQ(name(StressRecovery::element), "element");
}

}  // namespace tactel::fem::sensor_test
