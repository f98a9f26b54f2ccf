"""What a type checker and an editor see: the classes of ours, which are loaded by name."""

from typing import Any

from models.bead_chain import BeadChain as BeadChain
from models.belt_oscillator import BeltOscillator as BeltOscillator
from models.bilateral_rod import BilateralRod as BilateralRod
from models.billiard_ball import BilliardBall as BilliardBall
from models.bouncing_ball import BouncingBall as BouncingBall
from models.follower_force_arm import FollowerForceArm as FollowerForceArm
from models.incline import InclinedBlock as InclinedBlock
from models.lead_screw import LeadScrew as LeadScrew
from models.mode_coupling import ModeCoupling as ModeCoupling
from models.painleve_rod import PainleveRod as PainleveRod
from models.pendulum import WallPendulum as WallPendulum
from models.robot_finger import RobotFinger as RobotFinger
from models.rocking_block import RockingBlock as RockingBlock
from models.scenes.andrews_squeezer import AndrewsSqueezer as AndrewsSqueezer
from models.scenes.billiard_break import BilliardBreak as BilliardBreak
from models.scenes.block_on_incline import BlockOnIncline as BlockOnIncline
from models.scenes.box_stack import BoxStack as BoxStack
from models.scenes.car_on_bump import CarOnBump as CarOnBump
from models.scenes.card_house import CardHouse as CardHouse
from models.scenes.chalk_on_board import ChalkOnBoard as ChalkOnBoard
from models.scenes.conveyor import Conveyor as Conveyor
from models.scenes.crank_in_slot import CrankInSlot as CrankInSlot
from models.scenes.domino_row import DominoRow as DominoRow
from models.scenes.double_pendulum import DoublePendulum as DoublePendulum
from models.scenes.eulers_disc import EulersDisc as EulersDisc
from models.scenes.four_bars import FourBars as FourBars
from models.scenes.governor import Governor as Governor
from models.scenes.gripper import Gripper as Gripper
from models.scenes.hourglass import Hourglass as Hourglass
from models.scenes.jamming_drawer import JammingDrawer as JammingDrawer
from models.scenes.kapla_tower import KaplaTower as KaplaTower
from models.scenes.masonry_arch import MasonryArch as MasonryArch
from models.scenes.newtons_cradle import NewtonsCradle as NewtonsCradle
from models.scenes.pyramid import Pyramid as Pyramid
from models.scenes.rattleback import Rattleback as Rattleback
from models.scenes.rimless_wheel import RimlessWheel as RimlessWheel
from models.scenes.rolling_wheel import RollingWheel as RollingWheel
from models.scenes.shoe_brake import ShoeBrake as ShoeBrake
from models.scenes.slip_to_roll import SlipToRoll as SlipToRoll
from models.scenes.spatial_four_bar import SpatialFourBar as SpatialFourBar
from models.scenes.sphere_box import SphereBox as SphereBox
from models.scenes.tippe_top import TippeTop as TippeTop
from models.scenes.tumbling_box import TumblingBox as TumblingBox
from models.scenes.turntable import Turntable as Turntable
from models.scenes.vibrating_feeder import VibratingFeeder as VibratingFeeder
from models.scenes.wall import Wall as Wall
from models.scenes.wrecking_ball import WreckingBall as WreckingBall
from models.self_locking_rod import SelfLockingRod as SelfLockingRod
from models.slider_crank import SliderCrank as SliderCrank
from models.sliding_block import SlidingBlock as SlidingBlock
from models.spatial_painleve_rod import SpatialPainleveRod as SpatialPainleveRod
from models.spinning_top import SpinningTop as SpinningTop
from models.sprag_slip import SpragSlip as SpragSlip
from models.woodpecker import Woodpecker as Woodpecker
from nonsmooth.catalogue.entries import load as load
from nonsmooth.catalogue.entries import names as names

def __getattr__(name: str) -> Any: ...  # classes of other packages
