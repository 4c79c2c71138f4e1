# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

study = bpy.context.scene.w2w.body.w2w

study.sensor = "ideal"
study.rate = 100.0
study.window_s = 2.0
