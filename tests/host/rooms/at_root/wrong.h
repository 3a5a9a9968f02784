#include "host/support/errors.h"
