// The main program of the benchmarks. It has Google Benchmark's own options, and --version as in
// every program.

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstring>

#include "core/build_info/build_info.hpp"

int main(int count, char** words) {
  if (count == 2 && std::strcmp(words[1], "--version") == 0) {
    std::puts(feltwire::build_info("feltwire-bench").c_str());
    return 0;
  }
  benchmark::AddCustomContext("feltwire", feltwire::version());
  benchmark::Initialize(&count, words);
  if (benchmark::ReportUnrecognizedArguments(count, words)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
