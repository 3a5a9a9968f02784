// SPDX-License-Identifier: Apache-2.0

// The rules of a text of numbers, by hand.
#include "host/support/number_lines.h"

#include <gmock/gmock.h>

#include "host/support/errors.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace tactel::host::number_lines_test {

using ::testing::HasSubstr;
using Rows = std::vector<std::vector<double>>;

Rows rows_of(const std::string& text, NumberColumns columns = {}) {
  const ScratchFolder folder;
  NumberLines lines("a.csv", std::move(columns));
  Rows rows;
  read_number_file(folder.write("a.csv", text), 1 << 20, "file", lines,
                   [&](std::span<const double> numbers) { rows.emplace_back(numbers.begin(), numbers.end()); });
  return rows;
}

std::string refused(const std::string& text, const NumberColumns& columns = {}) {
  return thrown_message<ConfigError>([&] { rows_of(text, columns); });
}

TEST(NumberLines, EverySeparatorAndDecimalSign) {
  const Rows expected = {{1.5, -2}, {300, 0.25}};
  for (const char* text :
       {"1.5,-2\n3e2,.25\n", "1,5;-2\n3e2;0,25", "1.5\t-2\r\n3e2\t0,25\r\n", " 1.5  -2\n+3E+2 0.25 \n",
        "\xEF\xBB\xBF# scanned\n\n1.5;-2.\n# a remark\n3e2;0.25\n", "1.5 ; -2\n300 ; 0,25\n"})
    EXPECT_EQ(rows_of(text), expected) << text;
}

TEST(NumberLines, HeadersOfNamesAndOfCountedNames) {
  for (const char* header : {"a,b,c", ",0,1", "x,1,2", "\"a b\",\"c\",\"d\"", "t,2,3"})
    EXPECT_EQ(rows_of(std::string(header) + "\n0,0,0\n"), (Rows{{0, 0, 0}})) << header;
}

// pandas' to_csv(index=False) of an array; MATLAB counts from 1. Fewer columns may be numbers.
TEST(NumberLines, ALineThatNumbersTheColumnsIsNoLineOfNumbers) {
  for (const char* header : {"0,1,2,3", "1;2;3;4", "0 1 2 3 4 5"})
    EXPECT_THAT(refused(std::string(header) + "\n"),
                HasSubstr("a.csv:1: line = " + std::string(header) + ": must be numbers"));
  for (const char* numbers : {"0.0,1,2,3", "0,1,2", "2,3,4,5", "0,1,2,4", "0,-1,-2,-3", "0,1"})
    EXPECT_EQ(rows_of(std::string(numbers) + "\n").size(), 1u) << numbers;
  EXPECT_EQ(rows_of("1,1,1,1\n0,1,2,3\n").size(), 2u) << "below the first line";
  for (const auto& [header, count] : {std::pair("0,1", 2), {"0,1,2", 3}}) {
    const NumberColumns known{.count = static_cast<std::size_t>(count)};
    EXPECT_THAT(refused(std::string(header) + "\n", known), HasSubstr("this numbers the columns"));
    EXPECT_EQ(rows_of("0.0" + std::string(header).substr(1) + "\n", known).size(), 1u);
  }
}

TEST(NumberLines, WhatIsNoDecimalNumberIsRefused) {
  for (const char* wrong :
       {"nan", "-nan", "NaN", "inf", "-inf", "1e400", "1e39", "",   "0x10",  "1 2", "1.5.2", "--1", "++1",
        "+-1", "-+1",  "1e",  "1e+", "e5",   "1d5",   "1f",   "5%", "1_000", "'1'", "+",     "-",   "."})
    EXPECT_THAT(
        refused("1,2\n3," + std::string(wrong) + "\n"),
        HasSubstr("a.csv:2: column 2" + (*wrong != 0 ? " = " + std::string(wrong) : "") + ": must be a finite number"));
  EXPECT_THAT(refused("1;2\n1,2,3;4\n"), HasSubstr("column 1 = 1,2,3"));
  EXPECT_THAT(refused("1;2\n1.000,5;4\n"), HasSubstr("column 1 = 1.000,5"));
  EXPECT_THAT(refused("1\t2\n1,\t4\n"), HasSubstr("column 1 = 1,"));
  EXPECT_THAT(refused("1,2\n1;2\n"), HasSubstr("a.csv:2: fields = 1: must be 2"));
  EXPECT_THAT(refused("BAD,0.5,0.25\n"), HasSubstr("column 1 = BAD"));
}

TEST(NumberLines, NamesAndQuotes) {
  const NumberColumns point = {.count = 2, .meaning = "x and y", .names = {"x", "y"}, .quotes = false};
  EXPECT_EQ(rows_of("X [mm]; y_mm\n1;2\n", point), (Rows{{1, 2}}));
  EXPECT_THAT(refused("y,x\n1,2\n", point),
              HasSubstr("a.csv:1: header = (not shown): must be the names x,y of x and y"));
  EXPECT_THAT(refused("x,y\n1,secret\n", point), HasSubstr("a.csv:2: y = secret"));
  EXPECT_THAT(refused("1,secret\n", point), HasSubstr("a.csv:1: y = (not shown)"));
  EXPECT_THAT(refused("1,2,3\n", point), HasSubstr("a.csv:1: fields = 3: must be 2: x and y"));
}

}  // namespace tactel::host::number_lines_test
