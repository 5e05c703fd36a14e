// SPDX-License-Identifier: LGPL-2.1-or-later
// To be loaded before a program (LD_PRELOAD): of the allocations that its main() makes number $CSDTRACK_FAULT fails,
// from 0; with CSDTRACK_FAULT_LASTS=1 all later ones do, too. The last line of stderr is how many it asked for.
#include "../../faults.h"

#include <unistd.h>

#include <cstdio>

namespace {

using Main = int (*)(int, char **, char **);
Main program;

void say_how_many() {
  counting = false;
  char text[40];
  const int length = std::snprintf(text, sizeof text, "%ld allocations\n", calls[operator_new].load());
  if (write(STDERR_FILENO, text, static_cast<std::size_t>(length)) != length) std::abort();
}

int faulty_main(int argc, char **argv, char **environment) {
  if (const char *wanted = std::getenv("CSDTRACK_FAULT")) left[operator_new] = std::atol(wanted);
  lasting = std::getenv("CSDTRACK_FAULT_LASTS") != nullptr;
  counting = true;
  const int code = program(argc, argv, environment);
  say_how_many();
  return code;
}

}  // namespace

extern "C" int __libc_start_main(Main main, int argc, char **argv, void (*init)(), void (*end)(), void (*rtld_end)(),
                                 void *stack_end) {
  const auto real = reinterpret_cast<decltype(&__libc_start_main)>(dlsym(RTLD_NEXT, "__libc_start_main"));
  program = main;
  return real(faulty_main, argc, argv, init, end, rtld_end, stack_end);
}
