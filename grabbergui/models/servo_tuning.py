"""The few gains and limits of servoing that are worth a knob while it runs."""

from __future__ import annotations

from dataclasses import dataclass, replace

from grabbergui.servo.config import Config


@dataclass(frozen=True)
class Tuning:
    """What an operator sets; everything else is the configuration file's."""

    head_gain: float
    "Rad/s per radian off centre."
    head_fastest: float
    "Degrees per second."
    arm_gain: float
    "Twist per pose error, 1/s."
    arm_fastest: float
    "Millimetres per second."
    rate: float
    "Commands per second."

    @classmethod
    def of(cls, config: Config) -> Tuning:
        """As a configuration has it."""
        head, arm = config.head, config.arm
        return cls(head.gain, head.fastest, arm.gain, arm.fastest * 1e3, config.loop.rate)

    def applied_to(self, config: Config) -> Config:
        """The configuration with these values. Raises UsageError for those that cannot be together."""
        return replace(
            config,
            head=replace(config.head, gain=self.head_gain, fastest=self.head_fastest),
            arm=replace(config.arm, gain=self.arm_gain, fastest=self.arm_fastest * 1e-3),
            loop=replace(config.loop, rate=self.rate),
        )
