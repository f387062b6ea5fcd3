"""Public names of `flexmb.controllers`: controllers and motors."""

from flexmb.parts.controllers.control import Control as Control
from flexmb.parts.controllers.dc_motor import DCMotor as DCMotor
from flexmb.parts.controllers.pid import PID as PID
