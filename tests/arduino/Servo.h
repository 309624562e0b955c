struct Servo {
  int angle = 90, pin = 0;
  void attach(int to) { pins[pin = to] = angle; }
  void write(int to) { pins[pin] = angle = to; }
  int read() { return angle; }
};
