namespace {
int twice(double number) { return 2 * number; }
}  // namespace
