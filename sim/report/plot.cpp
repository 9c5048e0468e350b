#include "sim/report/plot.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>

#include "core/base/text.hpp"

namespace feltwire {

void plot(const std::filesystem::path& directory, const std::string& name,
          const std::string& script) {
  const std::filesystem::path file = directory / (name + ".gp");
  write_text(file, script);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  std::string program = "gnuplot", argument = name + ".gp";
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0)
    throw std::runtime_error(
        "cannot run gnuplot; install it (Debian: apt-get install gnuplot-nox)");
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR)
      throw std::runtime_error("lost track of gnuplot while it drew " + file.string());
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("gnuplot failed on " + file.string() +
                             "; run it there by hand to see why");
}

void plot_pair(const std::filesystem::path& directory, const std::string& name, int height,
               const std::string& styles, const std::string& title, const std::string& left,
               const std::string& right) {
  plot(directory, name,
       "set terminal pngcairo size 1300," + std::to_string(height) +
           " font 'Sans,11'\nset output '" + name + ".png'\n" + styles +
           "set multiplot layout 1,2 title '" + title + "'\n" + left + right + "unset multiplot\n");
}

}  // namespace feltwire
