/* Publishes sensor_msgs/msg/Image at a rate by ROS 2's client library for C: the least that a driver can do.
 *
 *   rcl_publisher TOPIC WIDTH HEIGHT RATE
 *
 * The Mono8 images lie in the message already; of each, only the stamp and the first pixel are new. Obeys lines
 * on its standard input: "begin" is answered with an empty line; "end" with CPU time since then (ns), resident
 * pages, and the stamps of the images since then (ns of the system's clock). Ends with its input.
 */
#define _GNU_SOURCE
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <rcl/error_handling.h>
#include <rcl/rcl.h>
#include <rosidl_runtime_c/primitives_sequence_functions.h>
#include <rosidl_runtime_c/string_functions.h>
#include <sensor_msgs/msg/image.h>

#define SECOND 1000000000LL
#define MOST_STAMPS 100000

static int64_t stamps[MOST_STAMPS];
static int stamped;

static int64_t now(clockid_t clock)
{
  struct timespec time;
  clock_gettime(clock, &time);
  return time.tv_sec * SECOND + time.tv_nsec;
}

static void check(int done, const char *what)
{
  if (done)
    return;
  fprintf(stderr, "%s failed: %s\n", what, rcl_get_error_string().str);
  exit(1);
}

static long resident_pages(void)
{
  long size = 0, resident = 0;
  FILE *file = fopen("/proc/self/statm", "r");
  if (file && fscanf(file, "%ld %ld", &size, &resident) != 2)
    resident = 0;
  if (file)
    fclose(file);
  return resident;
}

static void report(int64_t cpu)
{
  printf("%lld %ld", (long long)cpu, resident_pages());
  for (int number = 0; number < stamped; number++)
    printf(" %lld", (long long)stamps[number]);
  puts("");
  fflush(stdout);
}

/* Wait until a time of the monotonic clock and obey what is asked meanwhile; return 0 at the end of the input. */
static int obey_until(int64_t due, int64_t *cpu)
{
  for (;;) {
    int64_t left = due - now(CLOCK_MONOTONIC);
    struct timespec wait = {left > 0 ? left / SECOND : 0, left > 0 ? left % SECOND : 0};
    struct pollfd input = {STDIN_FILENO, POLLIN, 0};
    if (ppoll(&input, 1, &wait, NULL) <= 0) {
      if (left <= 0)
        return 1;
      continue;
    }
    char line[32] = {0};
    if (read(STDIN_FILENO, line, sizeof line - 1) <= 0)
      return 0;
    if (strncmp(line, "begin", 5) == 0) {
      stamped = 0;
      *cpu = now(CLOCK_PROCESS_CPUTIME_ID);
      puts("");
      fflush(stdout);
    } else {
      report(now(CLOCK_PROCESS_CPUTIME_ID) - *cpu);
    }
  }
}

int main(int count, char **arguments)
{
  if (count != 5)
    return 2;
  int width = atoi(arguments[2]), height = atoi(arguments[3]);
  int64_t period = (int64_t)(SECOND / atof(arguments[4]));

  rcl_allocator_t allocator = rcl_get_default_allocator();
  rcl_init_options_t options = rcl_get_zero_initialized_init_options();
  rcl_context_t context = rcl_get_zero_initialized_context();
  rcl_node_t node = rcl_get_zero_initialized_node();
  rcl_node_options_t node_options = rcl_node_get_default_options();
  rcl_publisher_t publisher = rcl_get_zero_initialized_publisher();
  rcl_publisher_options_t publisher_options = rcl_publisher_get_default_options();
  publisher_options.qos.depth = 5; /* REP 2003: reliable and volatile, as our server's */
  check(rcl_init_options_init(&options, allocator) == RCL_RET_OK, "rcl_init_options_init");
  check(rcl_init(0, NULL, &options, &context) == RCL_RET_OK, "rcl_init");
  check(rcl_node_init(&node, "rcl_publisher", "", &context, &node_options) == RCL_RET_OK, "rcl_node_init");
  check(rcl_publisher_init(&publisher, &node, ROSIDL_GET_MSG_TYPE_SUPPORT(sensor_msgs, msg, Image),
                           arguments[1], &publisher_options) == RCL_RET_OK, "rcl_publisher_init");

  sensor_msgs__msg__Image image;
  check(sensor_msgs__msg__Image__init(&image), "sensor_msgs__msg__Image__init");
  image.width = width;
  image.height = height;
  image.step = width;
  check(rosidl_runtime_c__String__assign(&image.encoding, "mono8"), "encoding");
  check(rosidl_runtime_c__String__assign(&image.header.frame_id, "camera"), "frame_id");
  check(rosidl_runtime_c__uint8__Sequence__init(&image.data, (size_t)width * height), "data");
  for (size_t place = 0; place < image.data.size; place++)
    image.data.data[place] = (uint8_t)place;

  int64_t cpu = 0;
  for (int64_t due = now(CLOCK_MONOTONIC); obey_until(due, &cpu);) {
    int64_t late = now(CLOCK_MONOTONIC) - due;
    due += late < period ? period : late; /* a camera does not catch up either */
    int64_t stamp = now(CLOCK_REALTIME);
    image.header.stamp.sec = (int32_t)(stamp / SECOND);
    image.header.stamp.nanosec = (uint32_t)(stamp % SECOND);
    image.data.data[0]++;
    if (stamped < MOST_STAMPS)
      stamps[stamped++] = stamp;
    check(rcl_publish(&publisher, &image, NULL) == RCL_RET_OK, "rcl_publish");
  }
  return 0;
}
