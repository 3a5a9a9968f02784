// SPDX-License-Identifier: Apache-2.0
#include "host/device/device.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>

#include "host/device/built_programs.h"
#include "host/device/compile_cache.h"
#include "host/device/opencl.h"
#include "host/device/program.h"
#include "tests/host/device/test_device.h"
#include "tests/scratch.h"

namespace tactel::host::device_test {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Device, PoclOffersBothOfItsDevices) {
  const auto devices = list_devices();
  const auto is_basic = [](const DeviceInfo& info) { return info.name.starts_with("basic"); };
  const auto basic = std::ranges::find_if(devices, is_basic);
  ASSERT_NE(basic, devices.end()) << "apt install pocl-opencl-icd";
  EXPECT_TRUE(basic->low_latency);
  EXPECT_TRUE(basic->zero_copy);
  EXPECT_TRUE(basic->fp64);
  EXPECT_EQ(basic->type, DeviceType::cpu);
  EXPECT_FALSE(Device("pthread").info().low_latency);
  for (std::size_t i = 0; i < devices.size(); ++i) EXPECT_EQ(devices[i].index, static_cast<int>(i));
}

// A vector register of the processor, as it says itself: 64 bytes with AVX-512, 32 with AVX, 16 without.
TEST(Device, LanesFillAVectorRegister) {
  if (const char* lanes = std::getenv("TACTEL_LANES"); lanes && *lanes)
    GTEST_SKIP() << "the lanes are those of TACTEL_LANES";
  const int bytes = __builtin_cpu_supports("avx512f") ? 64 : __builtin_cpu_supports("avx") ? 32 : 16;
  const Device device("basic");
  EXPECT_EQ(device.lanes(Precision::fp32), bytes / 4);
  EXPECT_EQ(device.lanes(Precision::fp64), bytes / 8);
}

TEST(Device, LanesCanBeAskedFor) {
  const char* const before = std::getenv("TACTEL_LANES");
  const std::string restored = before ? before : "";  // empty: none are asked for
  setenv("TACTEL_LANES", "1", 1);
  const Device one("basic");
  setenv("TACTEL_LANES", "3", 1);
  EXPECT_THROW(list_devices(), ConfigError);
  setenv("TACTEL_LANES", restored.c_str(), 1);
  EXPECT_EQ(one.lanes(Precision::fp32), 1);
  EXPECT_EQ(one.lanes(Precision::fp64), 1);
  EXPECT_EQ(one.interleaved(Precision::fp32), 64);
  EXPECT_EQ(Device("basic").with_lanes(16).interleaved(Precision::fp32), 1);
}

TEST(Device, ChosenByIndexPartOfNameOrDefault) {
  for (const DeviceInfo& info : list_devices()) EXPECT_EQ(Device(std::to_string(info.index)).info().name, info.name);
  EXPECT_THAT(Device("PTHread").info().name, StartsWith("pthread"));
  EXPECT_THAT(Device("portable computing").info().name, StartsWith("basic"));  // a platform: its best
  unsetenv("TACTEL_DEVICE");
  EXPECT_THAT(Device().info().name, StartsWith("basic"));
  setenv("TACTEL_DEVICE", "pthread", 1);
  EXPECT_THAT(Device().info().name, StartsWith("pthread"));
  EXPECT_THAT(Device("basic").info().name, StartsWith("basic"));
  unsetenv("TACTEL_DEVICE");
}

TEST(Device, ChosenByItsType) {
  EXPECT_THAT(Device("cpu").info().name, StartsWith("basic"));
  const auto devices = list_devices();
  const bool has_gpu = std::ranges::any_of(devices, [](const auto& info) { return info.type == DeviceType::gpu; });
  if (has_gpu)
    EXPECT_EQ(Device("gpu").info().type, DeviceType::gpu);
  else
    EXPECT_THROW(Device("gpu"), ConfigError);
}

// Networks train on a processor: a GPU's program would take them one by one.
TEST(Device, AGpuLeavesTrainingToTheProcessor) {
  const Device gpu = Device("basic").as_gpu();
  EXPECT_EQ(gpu.info().type, DeviceType::gpu);
  EXPECT_FALSE(gpu.info().zero_copy);
  EXPECT_EQ(gpu.lanes(Precision::fp32), 1);
  EXPECT_EQ(gpu.for_training().info().type, DeviceType::cpu);
  EXPECT_THAT(Device("pthread").for_training().info().name, StartsWith("pthread"));
}

TEST(Device, AGpuThatOpenClDoesNotShowIsNamed) {
  const ScratchFolder root;
  const std::vector<DeviceInfo> processor(1), gpu{{.type = DeviceType::gpu}};
  EXPECT_EQ(hidden_gpu_advice(processor, (root / "").string()), "");
  std::filesystem::create_directories(root / "dev");
  root.write("dev/nvidia0", "");
  EXPECT_THAT(hidden_gpu_advice(processor, (root / "").string()),
              testing::AllOf(HasSubstr("/dev/nvidia0"), HasSubstr("/etc/OpenCL/vendors/nvidia.icd"),
                             HasSubstr("libnvidia-opencl.so.1")));
  EXPECT_THAT(hidden_gpu_advice({}, (root / "").string()), HasSubstr("nvidia.icd"));
  EXPECT_EQ(hidden_gpu_advice(gpu, (root / "").string()), "");
}

TEST(Device, AnUnknownChoiceListsWhatThereIs) {
  for (const std::string choice : {"nonesuch", "99", "-1"}) try {
      const Device device(choice);
      FAIL() << choice;
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.key, "device");
      EXPECT_EQ(error.value, choice);
      for (const DeviceInfo& info : list_devices()) EXPECT_THAT(error.what(), HasSubstr(info.name));
    }
}

TEST(Device, AFailedCallNamesCallCodeAndDevice) {
  const Device device("basic");
  const auto empty = [&] {
    translated(device.info().name, [&] { cl::Buffer(device.context(), CL_MEM_READ_WRITE, 0); });
  };
  EXPECT_THAT(empty, throws_device_error("clCreateBuffer", "CL_INVALID_BUFFER_SIZE", device.info().name));
  EXPECT_THAT(empty,
              testing::ThrowsMessage<DeviceError>(HasSubstr("clCreateBuffer: CL_INVALID_BUFFER_SIZE on device basic")));
  EXPECT_EQ(cl_code_name(-54), "CL_INVALID_WORK_GROUP_SIZE");
  EXPECT_EQ(cl_code_name(-9999), "CL error -9999");
}

// Settings that must be there before the first OpenCL call: in a process of their own.
class FreshProcess : public testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};
using FreshProcessDeathTest = FreshProcess;

TEST_F(FreshProcessDeathTest, TheUsersPoclDevicesWin) {
  const auto with_pthread_only = [] {
    setenv("POCL_DEVICES", "pthread", 1);
    for (const DeviceInfo& info : list_devices())
      if (info.low_latency) std::exit(1);
    std::exit(list_devices().empty() ? 2 : 0);
  };
  EXPECT_EXIT(with_pthread_only(), testing::ExitedWithCode(0), "");
}

// PoCL compiles in a folder of the process. That is not for the programs that this one starts, and goes at its end.
TEST_F(FreshProcessDeathTest, PoclCompilesBesideOurCache) {
  const std::string folder = testing::TempDir() + "tactel_device_test";
  const auto where = [&] {
    unsetenv("POCL_CACHE_DIR");
    setenv("TACTEL_CACHE_DIR", folder.c_str(), 1);
    const Device device("basic");
    Program::from_text(device, "trivial.cl", "__kernel void trivial(__global int* out) { out[0] = 1; }", {});
    for (const auto& entry : std::filesystem::directory_iterator(compile_cache()->own()))
      if (entry.is_directory() && std::getenv("POCL_CACHE_DIR") == nullptr) std::exit(0);
    std::exit(1);
  };
  EXPECT_EXIT(where(), testing::ExitedWithCode(0), "");
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/pocl"))
    EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::StartsWith("process.")));
}

TEST_F(FreshProcessDeathTest, WithoutAPlaceForCachesThereAreStillDevices) {
  const auto without_cache = [] {
    unsetenv("POCL_CACHE_DIR");
    setenv("TACTEL_CACHE_DIR", "/dev/null/no/place", 1);
    std::exit(list_devices().empty() ? 1 : 0);
  };
  EXPECT_EXIT(without_cache(), testing::ExitedWithCode(0), "");
}

}  // namespace tactel::host::device_test
