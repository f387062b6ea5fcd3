"""Compiled gather-call-scatter over the pieces of a program; knows no physics."""
