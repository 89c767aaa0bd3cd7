#include "cli/commands.h"

int main(int argc, char** argv) { return lockstone::cli::run_command_line(argc, argv); }
