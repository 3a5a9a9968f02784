// SPDX-License-Identifier: Apache-2.0
#include "host/device/kernel_arguments.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "host/device/opencl.h"

namespace tactel::host {
namespace {

/// "global const vreal *lane_input": the last word is the name, the one before it the type.
KernelParameter parameter(std::string text, std::string_view real) {
  KernelParameter found;
  const std::size_t star = text.find('*');
  found.pointer = star != text.npos;
  if (found.pointer) text[star] = ' ';
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    found.type = std::move(found.name);
    found.name = std::move(word);
  }
  if (found.type == "real" || found.type == "vreal") found.type = real;
  return found;
}

bool is_number(std::string_view type) {
  constexpr std::string_view numbers[] = {"float",  "double", "char", "uchar", "short",
                                          "ushort", "int",    "uint", "long",  "ulong"};
  return std::ranges::find(numbers, type) != std::end(numbers);
}

}  // namespace

std::vector<KernelParameter> kernel_parameters(std::string_view source, std::string_view kernel,
                                               std::string_view real) {
  const std::string begin = "kernel void " + std::string(kernel) + "(";
  const std::size_t found = source.find(begin);
  if (found == source.npos) return {};
  const std::size_t first = found + begin.size();
  std::istringstream list(std::string(source.substr(first, source.find(')', first) - first)));
  std::vector<KernelParameter> parameters;
  for (std::string text; std::getline(list, text, ',');) parameters.push_back(parameter(text, real));
  return parameters;
}

bool takes_group(std::string_view source, std::string_view kernel) {
  const std::size_t start = source.find("kernel void " + std::string(kernel) + "(");
  if (start == source.npos) return false;
  const std::size_t next = source.find("kernel void ", start + 1);
  return source.substr(start, next == source.npos ? next : next - start).find("TAKE_GROUP(") != source.npos;
}

unsigned KernelArguments::place(std::string_view name) const {
  const auto found = std::ranges::find(parameters_, name, &KernelParameter::name);
  if (found == parameters_.end()) throw std::logic_error("the kernel has no argument " + std::string(name));
  return static_cast<unsigned>(found - parameters_.begin());
}

void KernelArguments::check(unsigned index, std::string_view type, bool pointer) const {
  if (index >= parameters_.size()) return;  // OpenCL refuses it
  const KernelParameter& wanted = parameters_[index];
  const bool same = wanted.pointer == pointer &&
                    (type.empty() ? !is_number(wanted.type) : wanted.type == type || !is_number(wanted.type));
  if (!same)
    throw std::logic_error("kernel argument " + wanted.name + " is " + wanted.type + (wanted.pointer ? "*" : "") +
                           ", not " + std::string(type) + (pointer ? "*" : ""));
}

void KernelArguments::set_bytes(unsigned index, const void* value, std::size_t size) {
  kernel_.setArg(index, size, value);
}

void KernelArguments::set_buffer(unsigned index, const cl::Buffer& buffer) { kernel_.setArg(index, buffer); }

}  // namespace tactel::host
