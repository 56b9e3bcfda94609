"""Checks of a patch that the model cannot make alone: they ask the controls, other tables and the score's structure.

A reader passes `patch_check.PATCH_CHECKS` as the context of the validation; each table runs its own check. It may
import what `show` may.
"""
