// SPDX-License-Identifier: Apache-2.0
#include "host/figures/plot.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "host/figures/gnuplot_script.h"
#include "host/support/bounded_file.h"
#include "host/support/child_process.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_picture = std::uintmax_t{1} << 30;

/// A folder of our own under the system's temporary one; gone when this is.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "tactel-plot-XXXXXX").string()) {
    if (::mkdtemp(path_.data()) == nullptr) throw PlotError("no temporary folder could be made: " + path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path operator/(const std::string& name) const { return fs::path(path_) / name; }

 private:
  std::string path_;
};

/// Empty where gnuplot drew nothing.
std::string read_picture(const fs::path& path) try {
  return read_bounded_file(path, largest_picture);
} catch (const UnreadableFile&) {
  return "";
}

/// The bytes of the picture that gnuplot makes.
std::string render(const Figure& figure, const std::string& terminal) {
  const TemporaryFolder folder;
  const fs::path script = folder / "figure.gp", picture = folder / "figure.out";
  write_file("figure", script, gnuplot_script(figure, terminal, picture.string()));
  const ChildResult result = run_child({"gnuplot", script.string()});
  const std::string drawn = read_picture(picture);
  if (result.exit_code == 127) throw PlotError("gnuplot is not installed (apt-get install gnuplot-nox)");
  if (result.exit_code != 0 || drawn.empty())
    throw PlotError(fmt::format("gnuplot ended with {}: {}", result.exit_code, result.err));
  return drawn;
}

}  // namespace

std::string render_svg(const Figure& figure) { return render(figure, "svg"); }

void check_figure_path(const std::string& option, const fs::path& path) {
  const std::string ending = path.extension().string();
  const auto refuse = [&](const char* allowed) { throw ConfigError("command line", option, path.string(), allowed); };
  if (ending != ".svg" && ending != ".png") refuse("a file name that ends in .svg or .png");
  if (!program_exists("gnuplot"))
    refuse("left out, or gnuplot installed (apt-get install gnuplot-nox): it draws the plots");
  check_writable(option, path);
}

void write_figure(const std::string& option, const fs::path& path, const Figure& figure) {
  check_figure_path(option, path);
  write_file(option, path, render(figure, path.extension() == ".png" ? "pngcairo" : "svg"));
}

}  // namespace tactel::host
