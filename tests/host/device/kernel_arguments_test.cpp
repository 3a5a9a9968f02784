// SPDX-License-Identifier: Apache-2.0

// Arguments are set by name and type; both are what OpenCL's compiler saw.
#include "host/device/kernel_arguments.h"

#include <gtest/gtest.h>

#include <regex>
#include <stdexcept>

#include "host/device/opencl.h"
#include "kernels/embedded.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::kernel_arguments_test {

const char* const text =
    "#include \"shared/lanes.h\"\n"
    "kernel void mixed(uint first_group, global const vreal *frames, real rate, real momentum, int steps, uint rows, "
    "global uchar *status) { }\n";

class Mixed : public testing::Test {
 protected:
  const Program program_ = Program::from_text(device(), "mixed.cl", text, {{"LANES", "4"}, {"REAL", "float"}});
  cl::Kernel kernel_ = program_.kernel("mixed");
  const std::vector<KernelParameter> parameters_ = program_.parameters("mixed");
  KernelArguments arguments_{kernel_, parameters_};
};

TEST_F(Mixed, TakesNamesAndTypesOfTheSource) {
  EXPECT_NO_THROW(arguments_.set("rate", 0.1f));
  EXPECT_NO_THROW(arguments_.set("frames", Buffer<float>(device(), 4)));
  EXPECT_NO_THROW(arguments_.set("status", Buffer<std::uint8_t>(device(), 4)));
  EXPECT_NO_THROW(arguments_.set("rows", 3u));
  EXPECT_NO_THROW(arguments_.set(4, 3));
}

TEST_F(Mixed, RefusesWhatOpenClWouldTake) {
  EXPECT_THROW(arguments_.set("rte", 0.1f), std::logic_error);
  EXPECT_THROW(arguments_.set("steps", 3u), std::logic_error);    // uint for int: the same size
  EXPECT_THROW(arguments_.set("steps", 0.1f), std::logic_error);  // and float
  EXPECT_THROW(arguments_.set("rate", 0.1), std::logic_error);
  EXPECT_THROW(arguments_.set(2, 7), std::logic_error);
  EXPECT_THROW(arguments_.set("frames", Buffer<std::int32_t>(device(), 4)), std::logic_error);
  EXPECT_THROW(arguments_.set("frames", 0.1f), std::logic_error);
  EXPECT_THROW(arguments_.set("rate", Buffer<float>(device(), 4)), std::logic_error);
}

TEST(KernelParameters, OfADoubleProgramAreDouble) {
  const auto parameters = kernel_parameters(text, "mixed", "double");
  ASSERT_EQ(parameters.size(), 7u);
  EXPECT_EQ(parameters[1].type, "double");
  EXPECT_TRUE(parameters[1].pointer);
  EXPECT_EQ(parameters[2].type, "double");
  EXPECT_EQ(parameters[6].name, "status");
  EXPECT_TRUE(kernel_parameters(text, "nonesuch", "float").empty());
}

/// "float4*" of a vector stands for its element: "float".
std::string element_of(std::string type) {
  type.erase(std::remove(type.begin(), type.end(), '*'), type.end());
  while (!type.empty() && (std::isdigit(static_cast<unsigned char>(type.back())) || type.back() == ' '))
    type.pop_back();
  if (type == "real" || type == "vreal") return "float";
  return type;
}

/// What a source needs beyond LANES and REAL: its line `// defines: A=1 B=2`, or `// defines of WIDE: ...`.
Defines defines_of(const kernels::Source& source) {
  Defines defines = {{"LANES", "4"}, {"REAL", "float"}};
  std::cmatch line;
  if (!std::regex_search(source.text.begin(), source.text.end(), line, std::regex("// defines( of WIDE)?:([^\n]*)")))
    return defines;
  if (line[1].matched) defines = {{"LANES", "1"}, {"WIDE", "4"}, {"REAL", "float"}};
  const std::string words = line[2];
  const std::regex pair("(\\w+)=(\\S+)");
  for (auto word = std::sregex_iterator(words.begin(), words.end(), pair); word != std::sregex_iterator(); ++word)
    defines.emplace_back((*word)[1], (*word)[2]);
  return defines;
}

// The launchers set arguments by the names and types that are read from the source's text. Here OpenCL's own compiler
// says what they are, for every kernel.
TEST(KernelParametersOnDevice, AreThoseThatTheCompilerSaw) {
  int kernels_seen = 0;
  for (const kernels::Source& source : kernels::sources()) {
    if (!source.name.ends_with(".cl")) continue;
    const std::string name(source.name), whole = expand_includes(name, std::string(source.text));
    std::string options = "-cl-std=CL1.2 -cl-kernel-arg-info";
    for (const auto& [key, value] : defines_of(source)) options += " -D" + key + "=" + value;
    cl::Program program(device().context(), whole);
    program.build(options.c_str());
    std::vector<cl::Kernel> kernels;
    program.createKernels(&kernels);
    for (const cl::Kernel& kernel : kernels) {
      ++kernels_seen;
      const std::string kernel_name = kernel.getInfo<CL_KERNEL_FUNCTION_NAME>();
      const auto ours = kernel_parameters(source.text, kernel_name, "float");
      ASSERT_EQ(ours.size(), kernel.getInfo<CL_KERNEL_NUM_ARGS>()) << kernel_name;
      for (cl_uint i = 0; i < ours.size(); ++i) {
        const std::string type = kernel.getArgInfo<CL_KERNEL_ARG_TYPE_NAME>(i);
        std::string name_there = kernel.getArgInfo<CL_KERNEL_ARG_NAME>(i);
        if (name_there.starts_with("_cl_")) name_there.erase(0, 4);  // PoCL's macro for the built-in of that name
        EXPECT_EQ(ours[i].name, name_there) << kernel_name;
        EXPECT_EQ(ours[i].type, element_of(type)) << kernel_name << " " << ours[i].name;
        EXPECT_EQ(ours[i].pointer, type.find('*') != std::string::npos) << kernel_name << " " << ours[i].name;
      }
    }
  }
  EXPECT_GE(kernels_seen, 8);
}

}  // namespace tactel::host::kernel_arguments_test
