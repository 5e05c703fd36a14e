// SPDX-License-Identifier: LGPL-2.1-or-later
// Loaded before a program (LD_PRELOAD). Of the allocations in its main(), number $CSDTRACK_FAULT, from 0, fails. With
// CSDTRACK_FAULT_LASTS=1 all later ones fail, too. The last line on stderr is the number of allocations.
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
