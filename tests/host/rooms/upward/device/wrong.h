#include "host/commands/command.h"
