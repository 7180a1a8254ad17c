// SPDX-License-Identifier: MIT
#include "program.hpp"

int main(int argc, char** argv) {
  return edvo::app::run_program(argc, argv);
}
