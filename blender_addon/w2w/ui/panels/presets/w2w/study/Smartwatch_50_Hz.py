# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

study = bpy.context.scene.w2w.body.w2w

study.sensor = "watch"
study.rate = 50.0
study.window_s = 2.0
