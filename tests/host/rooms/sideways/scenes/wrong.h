#include "host/device/device.h"
