"""A robot on Pinocchio: model, feet, Jacobians, dynamics."""

from surefoot.robot.catalog import robot_names
from surefoot.robot.contact_points import ContactPoints
from surefoot.robot.foot import Foot
from surefoot.robot.placement import place
from surefoot.robot.robot import Robot, load_robot

__all__ = ["ContactPoints", "Foot", "Robot", "load_robot", "place", "robot_names"]
